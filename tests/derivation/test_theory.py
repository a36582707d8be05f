"""Identities of the theory, decided exactly in the ring."""

import dataclasses

import mpmath
import pytest
from sympy import I, Integer, exp, simplify, sqrt

from derivation.adjoint import adjoint_problem, integrate_by_parts
from derivation.catalogue import objects
from derivation.constitutive import expand_model
from derivation.corrections import second_order
from derivation.errors import ModelError
from derivation.harmonics import first_order, split_real
from derivation.hierarchy import build_hierarchy
from derivation.jets import homomorphism, jet_ring
from derivation.kinematics import (
    ExactKinematics,
    cosine_and_sine,
    exact_kinematics,
    expand_kinematics,
    multiply,
)
from derivation.model import FOLLOWER, MODELS
from derivation.pipeline import derive
from derivation.present import expression
from derivation.resonance import resonant_part, third_order
from derivation.solvability import canonical, prove_equal, solvability
from derivation.symbols import symbol


def test_cosine_and_sine_series_satisfy_pythagoras(follower):
    ring = follower.kinematics.ring
    theta = (ring.zero, *(ring[f"theta{n}"] for n in (1, 2, 3)))
    cos, sin = cosine_and_sine(ring, theta)
    squares = [a + b for a, b in zip(multiply(cos, cos, ring), multiply(sin, sin, ring), strict=True)]
    assert squares == [ring.one, ring.zero, ring.zero, ring.zero]


@pytest.mark.parametrize("seed", [1, 2])
def test_expanded_kinematics_are_the_taylor_coefficients_of_the_exact_ones(follower, seed):
    """Random numbers for every jet; the exact strains as functions of epsilon, differentiated numerically."""
    import random

    rng = random.Random(seed)
    ring = follower.kinematics.ring
    value = {str(g): mpmath.mpf(rng.randint(-9, 9)) / 8 for g in ring.ring.gens}

    def field(name, suffix, eps, base=0):
        return base + sum(value[f"{name}{n}{suffix}"] * eps**n for n in (1, 2, 3))

    def rate(name, eps):
        return field(name, "_tau", eps) + eps**3 * value[f"{name}1_T"]

    def exact(eps):
        theta = field("theta", "", eps)
        c, s = mpmath.cos(theta), mpmath.sin(theta)
        x_u, y_u = field("x", "_u", eps, value["nu"]), field("y", "_u", eps)
        x_t, y_t = rate("x", eps), rate("y", eps)
        return [
            c * x_u + s * y_u, c * y_u - s * x_u, field("theta", "_u", eps),
            c * x_t + s * y_t, c * y_t - s * x_t, rate("theta", eps),
        ]  # fmt: skip

    with mpmath.workdps(40):
        for k, series in enumerate((*follower.kinematics.strains, *follower.kinematics.velocities)):
            taylor = mpmath.taylor(lambda eps, k=k: exact(eps)[k], 0, 3)
            for n in range(4):
                derived = sum(
                    (mpmath.mpf(int(c.x.numerator)) / int(c.x.denominator))
                    * mpmath.fprod(value[str(g)] ** e for g, e in zip(ring.ring.gens, m, strict=True) if e)
                    for m, c in series[n].terms()
                )
                assert mpmath.almosteq(derived, taylor[n], abs_eps=mpmath.mpf(10) ** -15)


def test_first_order_is_the_linear_problem(follower):
    r = follower.hierarchy.ring
    x, y, theta = follower.hierarchy[1].linear
    assert x == r["gamma1"] * r["x1_tau"] - r["k1"] * r["x1_uu"]
    assert y == r["y1_tau"] - r["k2"] * r["y1_uu"] + r["mu"] * r["theta1_u"]
    assert theta == (
        r["gamma3"] * r["theta1_tau"] - r["theta1_uu"] - r["mu"] * (r["y1_u"] - r["nu"] * r["theta1"])
    )
    stress = r["k2"] * (r["y1_u"] - r["nu"] * r["theta1"])
    assert follower.hierarchy[1].tip_linear == (r["k1"] * r["x1_u"], stress, r["theta1_u"])
    assert follower.hierarchy[1].slopes == (r.zero, r["nu"] * r["theta1"], r.zero)


def test_the_linear_part_is_the_same_at_every_order(follower):
    h, r = follower.hierarchy, follower.hierarchy.ring
    for n in (2, 3):
        raise_order = {
            r[str(g)]: r[str(g).replace("1", str(n), 1)]
            for row in h[1].linear
            for g in r.generators_of(row)
            if str(g)[0] in "xyt"
        }
        assert tuple(r.apply(row, raise_order) for row in h[1].linear) == h[n].linear


def test_tension_slopes_follow_from_the_constitutive_law(follower):
    """d/du of P = k1 (X' + ...) equals the force balance: exactly for P2, in the real part for P0."""
    modes = follower.second.modes
    ring = modes.ring
    for c in (follower.second.mean, follower.second.harmonic):
        by_law = modes.reduce(ring.derive(c.tension, "u"))
        difference = by_law - modes.reduce(c.tension_slope)
        assert (
            canonical(follower.hierarchy, ring, difference if c.harmonic else ring.real(difference))
            == ring.zero
        )


def test_tensions_vanish_at_the_tip(follower):
    modes = follower.second.modes
    ring = modes.ring
    for c in (follower.second.mean, follower.second.harmonic):
        slope = {ring[f"X{c.harmonic}_u"]: c.tip_slope}
        at_tip = modes.at_tip(ring.apply(c.tension, slope))
        assert (at_tip if c.harmonic else ring.real(at_tip)) == ring.zero


def test_half_plus_conjugate_restores_a_real_sum(follower):
    ring = follower.modes.ring
    p = ring["Theta"] * ring["Y_bar"]
    real = p + ring.conjugate(p) + ring["H"] * ring["H_bar"]
    half = split_real(ring, real)
    assert half + ring.conjugate(half) == real
    with pytest.raises(ArithmeticError, match="not real"):
        split_real(ring, p)


def test_lagrange_identity_for_generic_functions(follower):
    ring, adj = follower.modes.ring, follower.adjoint
    psi = ring["Psi_Y_bar"], ring["Psi_Theta_bar"]
    left = psi[0] * adj.primal[0] + psi[1] * adj.primal[1]
    right = ring["Y"] * adj.operator[0] + ring["Theta"] * adj.operator[1]
    assert left - right == ring.derive(adj.concomitant, "u")


def test_concomitant_vanishes_at_both_ends_under_both_sets_of_conditions(follower):
    modes, q = follower.adjoint.modes, follower.adjoint.concomitant
    assert canonical(follower.hierarchy, modes.ring, modes.at_tip(q)) == modes.ring.zero
    assert modes.at_clamp(q) == modes.ring.zero


def test_adjoint_conditions_are_needed(follower):
    """Without the adjoint conditions the concomitant does not vanish: the check above can fail."""
    primal_only = follower.modes
    assert primal_only.at_tip(follower.adjoint.concomitant) != primal_only.ring.zero


def test_integration_by_parts_of_a_single_term(follower):
    ring = follower.modes.ring
    p = ring["Psi_Y"] * ring["Y_uu"]
    rest, q = integrate_by_parts(ring, p, ("Y",))
    assert rest == ring["Psi_Y_uu"] * ring["Y"]
    assert q == ring["Psi_Y"] * ring["Y_u"] - ring["Psi_Y_u"] * ring["Y"]


def test_transformed_variables_do_what_they_are_for(follower):
    t, jets = follower.third.transformed, follower.hierarchy.ring
    assert t.local == jets["theta1"] ** 3 / 6
    assert t.rest == -jets["Delta"] * jets["k1_inv"] * jets["theta1"]
    assert not any(t.tip)


@pytest.mark.parametrize("power", [2, 3])
def test_another_profile_of_the_subtraction_gives_the_same_coefficients(follower, power):
    other = third_order(follower.hierarchy, follower.second, profile=lambda u: u**power / power)
    assert other.transformed.g[1] != follower.third.transformed.g[1]
    solvability(follower.hierarchy, other, follower.adjoint)  # proves equality with the boundary term kept


def test_a_profile_with_the_wrong_slope_is_refused(follower):
    with pytest.raises(ArithmeticError, match="not homogeneous"):
        third_order(follower.hierarchy, follower.second, profile=lambda u: u**2)


def test_a_wrong_forcing_breaks_the_equality_of_the_two_routes(follower):
    t, ring = follower.third.transformed, follower.modes.ring
    g1, g3 = t.resonant.cubic
    wrong = dataclasses.replace(t.resonant, cubic=(g1 + ring["Theta"] ** 2 * ring["Theta_bar"], g3))
    third = dataclasses.replace(follower.third, transformed=dataclasses.replace(t, resonant=wrong))
    with pytest.raises(ArithmeticError, match="total derivative"):
        solvability(follower.hierarchy, third, follower.adjoint)


def test_a_wrong_boundary_term_breaks_it_too(follower):
    ring = follower.modes.ring
    monomial = ring["Delta"] * ring["A"]
    shift = tuple(follower.modes.component(s, monomial) for s in follower.third.transformed.shift)
    kept = dataclasses.replace(follower.landau.detuning_kept, boundary=ring.zero)
    with pytest.raises(ArithmeticError, match="end terms"):
        prove_equal(follower.hierarchy, follower.adjoint, follower.landau.detuning, kept, shift)


def test_detuning_forcing_is_the_force_derivative_of_the_linear_operator(follower):
    """beta is the eigenvalue's slope: the untransformed detuning terms are dM/dF and dB/dF on the mode."""
    ring = follower.modes.ring
    nu_slope = -ring["k1_inv"]
    mu_slope = ring.one + ring["k2"] * nu_slope

    def d_force(p):
        return ring.reduce(p.diff(ring["nu"]) * nu_slope + p.diff(ring["mu"]) * mu_slope)

    for row, g in zip(follower.adjoint.primal, follower.third.bulk.detuning, strict=True):
        difference = follower.modes.reduce(d_force(row)) - g
        assert canonical(follower.hierarchy, ring, difference) == ring.zero
    stress = ring["k2"] * (ring["Y_u"] - ring["nu"] * ring["Theta"])
    assert follower.modes.at_tip(d_force(stress)) + follower.third.traction.detuning[0] == ring.zero


def test_cubic_terms_are_equivariant_under_a_phase_of_the_amplitude(follower):
    """Each term of f2, f3 of harmonic m carries A^p A*^q with p - q = m."""
    modes = follower.second.modes
    for row in follower.third.transformed.forcing:
        for m in modes.ring.parts(row, modes.amplitudes):
            assert abs(modes.harmonic(m)) in (1, 3)


def test_nothing_else_is_resonant(follower):
    modes = follower.second.modes
    with pytest.raises(ArithmeticError, match="unexpected resonant term"):
        resonant_part(modes, (modes.ring["A"] ** 3 * modes.ring["A_bar"] ** 2, modes.ring.zero))


def _derive_with(exact: ExactKinematics):
    law = expand_model(FOLLOWER, 3)
    hierarchy = build_hierarchy(FOLLOWER, law, expand_kinematics(exact, law, 3))
    second = second_order(hierarchy, first_order(hierarchy))
    third = third_order(hierarchy, second)
    return third, solvability(hierarchy, third, adjoint_problem(hierarchy, second.modes))


def test_a_sign_in_the_kinematics_changes_the_theory(follower):
    exact = exact_kinematics()
    h1, h2, curvature = exact.strains
    mutated = dataclasses.replace(
        exact, strains=(h1 - 2 * exact.ring["sin"] * exact.ring["y_u"], h2, curvature)
    )
    try:
        third, _ = _derive_with(mutated)
    except (ArithmeticError, ValueError):
        return
    assert third != follower.third


def test_polar_form(follower):
    a = follower.amplitude
    r = a.ring
    assert a.radial == (r["beta_re"] * r["Delta"] + r["alpha_re"] * r["R"] ** 2) * r["R"]
    assert a.phase == r["beta_im"] * r["Delta"] + r["alpha_im"] * r["R"] ** 2
    assert a.stability == -2 * r["beta_re"] * r["Delta"]


def test_characteristic_polynomial_at_zero_force_is_that_of_a_self_adjoint_rod(follower):
    e = follower.eigenproblem
    r = e.ring
    no_force = {r["force"]: r.zero, r["nu"]: r.one, r["mu"]: r["k2"]}
    c4, c2, c0 = (r.apply(c, no_force) for c in e.polynomial)
    lam = r["lam"]
    assert (c4, c2, c0) == (r["k2"], -lam - r["k2"] * r["gamma3"] * lam, lam**2 * r["gamma3"] + lam * r["k2"])


def _with(**changes):
    return dataclasses.replace(FOLLOWER, **changes)


_h1, _h2, _curvature = (symbol(q) for q in ("h1", "h2", "Pi"))


@pytest.mark.parametrize(
    ("model", "message"),
    [
        (_with(energy=FOLLOWER.energy + _h2), "not symmetric under reflection"),
        (_with(energy=FOLLOWER.energy + _h2 * _curvature), "couples shear and bending"),
        (_with(energy=FOLLOWER.energy - _curvature**2 / 2), "not convex"),
        (_with(energy=FOLLOWER.energy * symbol("stiffer")), "unknown symbol stiffer"),
        (_with(drag=(symbol("v1"), symbol("v1"), symbol("Omega"))), "drag component 2"),
        (_with(drag=(symbol("v1"), _h2 * symbol("v2"), symbol("Omega"))), "not symmetric under reflection"),
        (_with(tip_load=(-symbol("force"), symbol("force"), Integer(0))), "straight the tip load is"),
        (_with(energy=FOLLOWER.energy * symbol("force")), "unknown symbol force in the energy"),
        (
            _with(tip_load=(-symbol("force"), symbol("theta") ** 4, Integer(0))),
            "F2 is not symmetric under reflection",
        ),
        (
            _with(tip_load=(-symbol("force") + symbol("theta") ** 3, Integer(0), Integer(0))),
            "F1 is not symmetric under reflection",
        ),
        (_with(body_load=(symbol("force"), Integer(0), symbol("force"))), "tangential force"),
    ],
)
def test_a_model_that_breaks_an_assumption_is_refused_by_name(model, message):
    with pytest.raises(ModelError, match=message):
        derive(model)


@pytest.mark.parametrize("energy", [_curvature**2 / 2, sqrt(2) * _curvature**2, 3 * _curvature**2])
@pytest.mark.parametrize("load", ["dead", "follower"])
def test_any_bending_stiffness_derives_under_either_load(energy, load):
    theta, force = symbol("theta"), symbol("force")
    dead = (-force * symbol("cos"), force * symbol("sin"), Integer(0))
    model = _with(
        energy=FOLLOWER.energy - _curvature**2 / 2 + energy,
        tip_load=dead if load == "dead" else FOLLOWER.tip_load,
    )
    condition = derive(model).adjoint.tip
    assert theta not in model.energy.free_symbols
    assert any("Psi_Theta_u" in str(c) for c in condition)


@pytest.mark.parametrize("name", MODELS)
def test_what_is_shown_of_a_rod_is_its_eigenvalue_problem_and_its_corrections(name):
    """i omega Gamma (Y, Theta) = M (Y, Theta) and (K1 X')' = ... with this rod's own drag and stiffness."""
    d = derive(MODELS[name])
    shown, straight, ring = objects(d), d.hierarchy.straight, d.hierarchy.ring
    weights = [expression(ring, w) for w in straight.weights[1:]]
    for key, s in (("mode", ("Y", "Theta")), ("adjoint", ("Psi_Y", "Psi_Theta"))):
        for equation, w, shape in zip(shown[key].equations, weights, s, strict=False):
            sign = -1 if key == "adjoint" else 1
            assert (equation.lhs / (sign * I * symbol("omega") * symbol(shape)) - w).simplify() == 0
    stiffness = expression(ring, straight.stiffness[0])
    assert (shown["X0"].equations[0].lhs.diff(symbol("X0_uu")) - stiffness).simplify() == 0


def test_the_stretch_is_that_of_the_stiffness_that_holds_it():
    k1, k2 = symbol("k1"), symbol("k2")
    d = derive(_with(energy=k2 * (_h1 - 1) ** 2 / 2 + k1 * _h2**2 / 2 + _curvature**2 / 2))
    straight, ring = d.hierarchy.straight, d.hierarchy.ring
    assert simplify(expression(ring, straight.nu) - (1 - symbol("force") / k2)) == 0


@pytest.mark.parametrize("name", [name for name in MODELS if name != "follower"])
def test_every_shipped_rod_derives_with_its_proofs(name):
    """Lagrange's identity, the adjoint conditions and the equality of both routes are checked on the way."""
    d = derive(MODELS[name])
    assert (d.third.transformed is None) == (name == "partial_follower")
    assert (d.eigenproblem is None) == (name == "distributed")


def test_the_slope_of_a_coefficient_is_the_next_coefficient():
    """Where the stretch varies; of each letter by its formula. No letter's slope is held twice."""
    nu, u = symbol("nu"), symbol("h1") - 1
    model = _with(
        energy=symbol("k1") * (exp(u) - u) + symbol("k2") * (1 + u**2) * _h2**2 + exp(-u) * _curvature**2 / 2,
        drag=(symbol("v1") * exp(u * _h2**2), exp(u) * symbol("v2"), symbol("Omega")),
        tip_load=(Integer(0),) * 3,
        body_load=(-symbol("force"), Integer(0), Integer(0)),
    )
    law = expand_model(model, 3)
    known = {symbol(name): e for name, e in law.constants.items()}
    beyond = {name for name, slope in law.slopes.items() if slope is None}
    assert beyond == {"W_500", "W_302", "C2_300"}
    for name, slope in law.slopes.items():
        if name not in beyond:
            assert simplify(slope.xreplace(known) - law.constants[name].diff(nu)) == 0
    assert law.slopes["K1"] == 6 * symbol("W_300")
    assert law.slopes["K2"].free_symbols == {symbol("k2"), nu}  # a polynomial needs no letter
    assert law.slopes["K3"] == 2 * symbol("W_102")


def test_rods_that_reduce_to_the_follower_do(follower):
    """chi = 1 and vanishing quartic stiffness give the follower's cubic terms back."""
    for name, gone in (("partial_follower", {"chi": 1}), ("quartic", {"stretch4": 0, "bend4": 0})):
        d = derive(MODELS[name])
        ring, limit = d.modes.ring, {}
        for parameter, value in gone.items():
            limit[ring[parameter]] = ring.one * value
        if name == "quartic":
            limit |= {ring["K1"]: ring["k1"]}
            inverse = jet_ring([*map(str, ring.ring.symbols)], inverses={"k1": "K1_inv"})
        for ours, theirs in zip(d.third.bulk.cubic, follower.third.bulk.cubic, strict=True):
            p = ring.apply(ours, limit)
            if name == "quartic":
                p = homomorphism(p, {ring["K1_inv"]: inverse["K1_inv"]}, inverse)
                p = inverse.reduce(p)
            q = {str(m): c for m, c in _plain(p).items()}
            assert q == _plain(follower.modes.ring.reduce(theirs))


def _plain(p):
    """Terms by name, so that elements of different rings compare; both letters for 1/k1 are one."""
    terms = {}
    for m, c in p.terms():
        names = sorted(
            (str(g).replace("K1_inv", "k1_inv"), e) for g, e in zip(p.ring.gens, m, strict=True) if e
        )
        terms[str(names)] = c
    return terms


def test_only_order_three_is_derived():
    with pytest.raises(ValueError, match="order = 4"):
        derive(order=4)
