"""Digits and proofs of rods other than the plain one: against float64, the discretised rod, each other."""

import json
from dataclasses import replace

import mpmath as mp
import numpy as np
import pytest

from rodwnl import RodParameters, cli, kernels, landau
from rodwnl.closedform import coefficients, critical_state
from rodwnl.collocated import leading_eigenvalues, unstable_count
from rodwnl.dialects import convert
from rodwnl.errors import ComputationError, InputError
from rodwnl.exact import MpNumbers, _require_consistent, characteristic, exact_threshold
from rodwnl.exact_responses import exact_amplitude_equation
from rodwnl.models import emitted
from rodwnl.normalform import normal_form
from rodwnl.responses import amplitude_equation
from rodwnl.straightrod import arguments
from rodwnl.strainform import follower

from .theorems import assert_emitted_determinant, assert_energy_identity

# Everything that the theory takes at once: an implicit stretch, stiffnesses and drags that vary with it, a
# part of the load that keeps its direction, a spring, a damper and drag at the tip.
LOADED = """
name = "loaded"
energy = "k1*(h1 - 1)^2/2 + s*(h1 - 1)^4/4 + k2*h2^2/2*exp(soft*(1 - h1)) + Pi^2/2*(1 + b*(h1 - 1))"
[parameters]
s = { default = "60" }
soft = { default = "0.3" }
b = { default = "0.4" }
chi = { default = "0.8" }
[drag]
v1 = "gamma1*sqrt(h1^2 + h2^2)"
v2 = "sqrt(h1)"
Omega = "gamma3*h1"
[tip]
F1 = "-force*(chi + (1 - chi)*cos(theta)) - 0.05*v1"
F2 = "force*(1 - chi)*sin(theta) - 0.1*v2"
M = "-0.5*sin(theta) - 0.001*Omega"
"""
COUPLED = """
name = "coupled"
energy = "k1*(h1 - 1)^2/2 + k2*h2^2/2 + Pi^2/2"
[drag]
v1 = "gamma1"
v2 = "1"
Omega = "gamma3"
[tip]
F1 = "-force"
F2 = "-0.1*v2 - 0.002*Omega"
M = "-0.3*theta - 0.003*v2 - 0.001*Omega"
"""
SOFT = (200, "1e4", "1e-4")
NUMBERS = ("force", "omega", "alpha", "beta", "A_tip2_slope", "omega_slope")


def derived(text, folder):
    """The rod of a text, derived into a cache that this module has to itself."""
    file = folder / "rod.toml"
    file.write_text(text)
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("RODWNL_CACHE", str(folder / "cache"))
        return RodParameters(*SOFT, model=emitted(str(file)))


@pytest.fixture(scope="module")
def loaded(tmp_path_factory):
    return derived(LOADED, tmp_path_factory.mktemp("loaded"))


@pytest.fixture(scope="module")
def coupled(tmp_path_factory):
    return derived(COUPLED, tmp_path_factory.mktemp("coupled"))


@pytest.fixture(params=["metric_drag", "quartic", "partial_follower", "loaded"])
def rod(request):
    return the_rod(request, request.param)


def the_rod(request, name):
    derived = name in ("loaded", "coupled")
    return request.getfixturevalue(name) if derived else RodParameters(*SOFT, model=name)


@pytest.fixture
def found(rod):
    return landau(rod, escalate=False)


def test_digits_stay_and_agree_with_double_precision(rod, found):
    assert len(found) == 2
    for c in found:
        few, many = (exact_threshold(rod, c.force, c.omega, digits) for digits in (20, 50))
        assert max(few.residuals.values()) < 1e-30
        with mp.workdps(60):
            for name in NUMBERS:
                a, b = getattr(few, name), getattr(many, name)
                assert 0 < abs(a - b) < mp.mpf(10) ** -20 * abs(b)
                error = getattr(c.threshold if name in ("force", "omega") else c, f"{name}_error")
                assert abs(mp.mpmathify(getattr(c, name)) - b) <= error
        assert (few.crossing, few.criticality) == (c.crossing, c.criticality)
        for part, other in zip(
            (*few.alpha_parts, *few.beta_parts), (*c.alpha_parts, *c.beta_parts), strict=True
        ):
            assert complex(part) == pytest.approx(other, rel=1e-6)


def test_beta_is_the_slope_of_the_eigenvalue(rod, found):
    # D(λ, F) = 0 with λ = iω, ω complex: dλ/dF = −i D_F/D_ω
    t = exact_threshold(rod, found[0].force, found[0].omega, 30)
    with mp.workdps(50):
        h = mp.mpf(10) ** -15

        def slope(by_force, by_omega):
            forward, backward = (
                characteristic(rod, t.force * (1 + sign * by_force), t.omega * (1 + sign * by_omega))
                for sign in (1, -1)
            )
            return forward - backward

        by_force, by_omega = slope(h, 0) / t.force, slope(0, h) / t.omega
        assert abs(-1j * by_force / by_omega / t.beta - 1) < 1e-20


def law(k1, k2, gamma3, gamma1, *, s, soft, b, chi):
    """The rod `loaded` once more, by hand."""
    from rodwnl.nilpotent import Nilpotent, cos, sin

    def exp(value):
        return value.apply(lambda a, k: np.exp(a)) if isinstance(value, Nilpotent) else np.exp(value)

    def stress(h1, h2, pi):
        e, shear = h1 - 1.0, k2 * exp(soft * (1.0 - h1))
        return (
            k1 * e + s * e**3 - soft * shear * h2 * h2 / 2 + b * pi * pi / 2,
            shear * h2,
            pi + b * e * pi,
        )

    return replace(
        follower(k1, k2, gamma3, gamma1),
        stress=stress,
        drag=lambda h1, h2, pi: (gamma1 * (h1 * h1 + h2 * h2) ** 0.5, h1**0.5, gamma3 * h1),
        load=lambda theta, v, force: (
            -force * (chi + (1.0 - chi) * cos(theta)) - 0.05 * v[0],
            force * (1.0 - chi) * sin(theta) - 0.1 * v[1],
            -0.5 * sin(theta) - 0.001 * v[2],
        ),
    )


def test_the_discretised_rod_confirms_the_digits(loaded):
    c = landau(loaded)[0]
    e = exact_threshold(loaded, c.force, c.omega, 20)
    form = normal_form(law(200.0, 1e4, 1e-4, 0.5, s=60.0, soft=0.3, b=0.4, chi=0.8), 29.85, 136.4)
    assert abs(form.alpha / complex(e.alpha) - 1) < 1e-10
    assert abs(form.beta / complex(e.beta) - 1) < 1e-10


def test_metric_drag_only_rescales_time_in_the_linear_problem():
    plain = exact_threshold(RodParameters(*SOFT), 49.76, 334.32, 40)
    metric = exact_threshold(RodParameters(*SOFT, model="metric_drag"), 49.76, 445, 40)
    with mp.workdps(45):
        assert abs(metric.force - plain.force) < mp.mpf(10) ** -39 * plain.force
        assert abs(metric.omega * (1 - plain.force / 200) - plain.omega) < mp.mpf(10) ** -39 * plain.omega


def test_terms_that_vanish_give_the_plain_rod():
    plain = exact_threshold(RodParameters(*SOFT), 49.76, 334.32, 40)
    for model, own in (("quartic", {"stretch4": 0, "bend4": 0}), ("partial_follower", {"chi": 1})):
        same = exact_threshold(RodParameters(*SOFT, model=model, **own), 49.76, 334.32, 40)
        with mp.workdps(45):
            for name in NUMBERS:
                a, b = getattr(same, name), getattr(plain, name)
                assert abs(a - b) < mp.mpf(10) ** -39 * abs(b)


def test_a_coincidence_of_exponents_is_removable():
    """(r1 + r2)² = 2iωγ1/k1, where X2 is resonant, of a load that holds its direction in part."""
    values, omega = ("100", "10", "0.5"), mp.mpf(20)
    with mp.workdps(60):

        def state(force, gamma1="1/2"):
            rod = RodParameters(*values, gamma1, model="partial_follower", chi="0.7")
            return critical_state(rod, force, omega, MpNumbers())

        def squared(force):
            r1, _, r2, *_ = state(force).exponents.basis
            return max(((r1 + sign * r2) ** 2 for sign in (1, -1)), key=lambda z: z.imag)

        force = mp.findroot(
            lambda F: squared(F).real, (mp.mpf("0.1"), mp.mpf(3)), solver="anderson", tol=1e-110
        )
        exact = 100 * squared(force).imag / (2 * omega)

        def alpha(factor):
            at = state(force)
            straight = replace(at.straight, values={**at.straight.values, "gamma1": exact * factor})
            basis = at.exponents.basis
            exponents = type(at.exponents)(
                [basis[0], basis[2], mp.sqrt(2 * at.lam * exact * factor / 100)], MpNumbers()
            )
            return coefficients(replace(at, straight=straight, exponents=exponents)).alpha

        on = alpha(mp.mpf(1))
        for gap in (mp.mpf("1e-3"), mp.mpf("1e-8")):
            assert abs((alpha(1 + gap) + alpha(1 - gap)) / 2 - on) < 1e4 * gap**2 * abs(on)


def test_formulas_that_contradict_each_other_give_no_digits(rod, found):
    with mp.workdps(40):
        c = coefficients(critical_state(rod, mp.mpf(found[0].force), mp.mpf(found[0].omega), MpNumbers()))
    with pytest.raises(ComputationError, match="the formulas contradict each other"):
        _require_consistent(replace(c, residuals={**c.residuals, "adjoint": mp.mpf(1)}), 20)


def test_order_five_agrees_with_quadrature(coupled):
    c = landau(coupled)[0]
    exact = exact_amplitude_equation(coupled, c.force, c.omega, 10)
    near = amplitude_equation(coupled, c.threshold)
    for coefficient, value in exact.coefficients.items():
        assert near.coefficients[coefficient] == pytest.approx(complex(value), rel=1e-8)
    assert near.A_tip2_curvature == pytest.approx(float(exact.A_tip2_curvature), rel=1e-7)
    assert near.omega_curvature == pytest.approx(float(exact.omega_curvature), rel=1e-7)


def test_double_precision_hands_over_where_it_is_too_coarse():
    hard = RodParameters("180.8", "33810000", "0.0001672", "0.1392", model="quartic")
    kept, raised = landau(hard, escalate=False)[0], landau(hard)[0]
    assert kept.digits < 8 <= raised.digits
    assert abs(kept.alpha - raised.alpha) <= kept.alpha_error
    assert raised.alpha_parts == pytest.approx(kept.alpha_parts, rel=1e-5)


def test_a_convention_scales_by_the_rods_own_drag(loaded):
    c = landau(loaded)[0]
    e = exact_threshold(loaded, c.force, c.omega, 20)
    weighted, nodal = (convert(loaded, e, *d) for d in (("ff-bifbox", None), ("kuznetsov", 100)))
    assert complex(weighted.numbers["alpha"]) == pytest.approx(-c.beta, rel=1e-9)
    # the drop at the tip alone has 0.1 |Y(1)|² of the square
    assert 0.1 < float(weighted.norm) ** 2 < float(nodal.norm) ** 2
    assert complex(nodal.numbers["c1"]) == pytest.approx(c.alpha / float(nodal.norm) ** 2, rel=1e-9)


# Proofs


@pytest.fixture
def bits():
    pytest.importorskip("flint", reason="python-flint, the extra `certified`, is not installed")
    from rodwnl.balls import working_bits

    with working_bits(128):
        yield


@pytest.mark.usefixtures("bits")
def test_balls_contain_the_digits_and_the_pair_is_leading(rod, found):
    import flint

    from rodwnl.balls import relative_accuracy
    from rodwnl.certified import certify_threshold

    for c in found:
        proved, e = certify_threshold(rod, c.force, c.omega, 30), exact_threshold(rod, c.force, c.omega, 40)
        assert (proved.crossing, proved.criticality, proved.unstable) == (c.crossing, c.criticality, 0)
        implicit = "nu" in arguments(kernels.load(rod.model).straight_rod)
        assert implicit == any("stretch stiffness is positive" in s for s in proved.proved)
        balls = [proved.force, proved.omega, proved.A_tip2_slope, proved.omega_slope]
        numbers = [e.force, e.omega, e.A_tip2_slope, e.omega_slope]
        balls += [*proved.alpha, *proved.beta]
        numbers += [e.alpha.real, e.alpha.imag, e.beta.real, e.beta.imag]
        for ball, number in zip(balls, numbers, strict=True):
            text = flint.arb(mp.nstr(number, 42))
            assert ball.overlaps(flint.arb(text, abs(text) * flint.arb("1e-40")))
            assert relative_accuracy(ball) >= 30


@pytest.mark.usefixtures("bits")
def test_counts_agree_with_the_float_spectrum(rod, found):
    import flint

    from rodwnl.halfplane import count_right_of, unstable_region
    from rodwnl.linearrod import linear_rod, require_form

    line = flint.arb("1e-6")
    for force in (20.0, found[0].force * 1.01, found[1].force * 0.99, found[1].force * 1.001):
        here = linear_rod(rod, flint.arb(force))
        require_form(rod, flint.arb(force))
        assert count_right_of(here, line, unstable_region(here, line)) == unstable_count(rod, force)


@pytest.mark.usefixtures("bits")
def test_every_eigenvalue_in_sight_obeys_the_bound(rod):
    import flint

    from rodwnl.halfplane import unstable_region
    from rodwnl.linearrod import linear_rod

    for force in (1.0, 30.0, 60.0):
        region = unstable_region(linear_rod(rod, flint.arb(force)), flint.arb(50))
        for lam in leading_eigenvalues(rod, np.array([force]))[0].ravel():
            if lam.real > -50:
                assert lam.real < float(region.right)
                assert abs(lam.imag) < float(region.top)


@pytest.mark.usefixtures("bits")
@pytest.mark.parametrize("name", ["metric_drag", "quartic", "partial_follower", "loaded", "coupled"])
def test_the_characteristic_function_is_the_emitted_determinant(request, name):
    assert_emitted_determinant(the_rod(request, name), 11)


@pytest.mark.usefixtures("bits")
def test_the_energy_identity_holds_on_a_mode(rod, found):
    assert_energy_identity(rod, found[0].force, found[0].omega)


@pytest.mark.usefixtures("bits")
def test_a_load_that_couples_the_rates_has_digits_but_no_count(coupled):
    from rodwnl.certified import certify_threshold

    c = landau(coupled)[0]
    assert complex(exact_threshold(coupled, c.force, c.omega, 20).alpha) == pytest.approx(c.alpha, rel=1e-8)
    with pytest.raises(ComputationError, match=r"the count of unstable eigenvalues: .*drag only brakes"):
        certify_threshold(coupled, c.force, c.omega)


@pytest.mark.usefixtures("bits")
def test_the_stretch_is_enclosed_and_belongs_to_the_unloaded_rod():
    import flint

    from rodwnl.linearrod import linear_rod

    soft = RodParameters(*SOFT, model="quartic", stretch4=-100)
    nu = linear_rod(soft, flint.arb(50)).nu.real
    # 200 e − 100 e³ = −50 with e = ν − 1
    with mp.workdps(40):
        e = mp.findroot(lambda e: 200 * e - 100 * e**3 + 50, -0.25)
        assert nu.overlaps(flint.arb(mp.nstr(1 + e, 38)))
    assert nu.rad() < 1e-30
    wide = linear_rod(soft, flint.arb(50, 5)).nu.real
    assert all(wide.contains(linear_rod(soft, flint.arb(f)).nu.real) for f in (45, 47, 55))
    with pytest.raises(ComputationError, match="no straight state at force = 109"):
        linear_rod(soft, flint.arb(109))


@pytest.mark.usefixtures("bits")
def test_rows_of_another_form_prove_nothing(monkeypatch):
    import flint

    from rodwnl import linearrod

    right = linearrod.linear_rod
    monkeypatch.setattr(linearrod, "linear_rod", lambda *a: replace(right(*a), mu=right(*a).mu * 2))
    with pytest.raises(ComputationError, match="emitted y_row does not have the form"):
        linearrod.require_form(RodParameters(*SOFT, model="quartic"), flint.arb(10))


# Commands

ROD = ["--k1", "200", "--k2", "1e4", "--gamma3", "1e-4"]


@pytest.mark.parametrize("model", ["metric-drag", "quartic", "partial-follower"])
def test_commands_give_digits_and_balls_as_json(capsys, model):
    def document(*arguments):
        assert cli.run([*arguments, "--model", model, *ROD, "--json"]) == 0
        return json.loads(capsys.readouterr().out)["thresholds"]

    near, exact = document("landau"), document("landau", "--digits", "50")
    for a, b in zip(near, exact, strict=True):
        assert len(b["force"].replace(".", "")) == 50
        assert float(a["alpha"][0]) == pytest.approx(float(b["alpha"][0]), rel=1e-7)
    pytest.importorskip("flint", reason="python-flint, the extra `certified`, is not installed")
    for a, b in zip(exact, document("hopf", "--certified", "--digits", "30"), strict=True):
        with mp.workdps(60):
            assert abs(mp.mpf(b["force"]["mid"]) - mp.mpf(a["force"])) <= mp.mpf(b["force"]["rad"])


def test_a_stretch_that_varies_is_refused_with_the_reason():
    rod = RodParameters(*SOFT, model="distributed")
    with pytest.raises(InputError, match="that of 'distributed' varies along it under its distributed load"):
        exact_threshold(rod, 76.0, 300.0)
