"""Every derived object by its name: what ``rodwnl derive --show NAME`` prints.

An object is one or more equations, left-hand side in the paper's letters, right-hand side computed.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass

from sympy import Eq, Expr, I, Integer, Integral, Symbol
from sympy.polys.rings import PolyElement

from derivation.jets import JetRing, homomorphism
from derivation.motion import equations_of_motion
from derivation.pipeline import Derivation
from derivation.present import expression
from derivation.resonance import Transformation
from derivation.symbols import BAR, FIELDS, jet_name, latex_of, register, symbol

STRAINS = ("h1", "h2", "Pi")
VELOCITIES = ("v1", "v2", "Omega")
STRESSES = ("F1", "F2", "M")
#: How the paper's labels call the orders.
_ADJECTIVE = {1: "linear", 2: "quadratic", 3: "cubic"}
_ZERO = Integer(0)


@dataclass(frozen=True)
class Object:
    """One derived object. ``stage`` is the module that derived it, ``label`` the paper's, if it has one."""

    name: str
    title: str
    stage: str
    label: str
    equations: tuple[Eq, ...]


def objects(d: Derivation) -> Mapping[str, Object]:
    """All derived objects of a rod, in the order of the derivation."""
    stages = (
        _kinematics,
        _hierarchy,
        _linear_problem,
        _second_order,
        _third_order,
        _adjoint,
        _solvability,
        _amplitude,
        _normal_form,
    )
    return {o.name: o for stage in stages for o in stage(d)}


def _equal(left: Expr, right: Expr) -> Eq:
    return Eq(left, right, evaluate=False)


def _graded(name: str, n: int) -> Symbol:
    """h1 at order n: ``h1_3`` in text, h_1^{(3)} in LaTeX."""
    latex = {"Pi": r"\Pi", "Omega": r"\Omega"}.get(name, f"{name[0]}_{name[1:]}")
    return register(f"{name}_{n}", f"{latex}^{{({n})}}")


def _kinematics(d: Derivation) -> Iterator[Object]:
    motion = equations_of_motion(d.model, d.exact)
    exact = (
        ("exact strain", "eq:definitions", STRAINS, motion.strains),
        ("exact velocity", "eq:definitions", VELOCITIES, motion.velocities),
        ("stress", "eq:constitutive", STRESSES, motion.stresses),
    )
    for title, label, names, values in exact:
        for name, e in zip(names, values, strict=True):
            yield Object(name, title, "kinematics", label, (_equal(symbol(name), e),))
    rates = tuple(_equal(symbol(f"{f}_t"), e) for f, e in zip(FIELDS, motion.rates, strict=True))
    yield Object("motion", "full nonlinear equations of motion", "motion", "eq:dynamicsfull", rates)
    ring, order = d.kinematics.ring, d.kinematics.order
    expanded = (("strain", STRAINS, d.kinematics.strains), ("velocity", VELOCITIES, d.kinematics.velocities))
    for kind, names, values in expanded:
        for name, series in zip(names, values, strict=True):
            for n in range(1, order + 1):
                left = _graded(name, n)
                right = expression(ring, series[n])
                label = f"eq:{kind}{_ADJECTIVE.get(n, n)}"
                yield Object(left.name, f"{kind} at order {n}", "kinematics", label, (_equal(left, right),))


def _hierarchy(d: Derivation) -> Iterator[Object]:
    h, ring = d.hierarchy, d.hierarchy.ring
    straight = h.straight
    stretch = _equal(expression(ring, straight.balance), _ZERO)
    if straight.nu is not None:
        stretch = _equal(symbol("nu"), expression(ring, straight.nu))
    yield Object("nu", "stretch of the straight rod", "hierarchy", "eq:basestate", (stretch,))
    mu = _equal(symbol("mu"), expression(ring, straight.mu))
    yield Object("mu", "stiffness of the linear problem", "hierarchy", "eq:linearization", (mu,))
    if d.law.constants:
        letters = tuple(_equal(symbol(name), e) for name, e in d.law.constants.items())
        yield Object("letters", "coefficients at the straight rod", "constitutive", "", letters)
    tip_labels = {1: "eq:followerlinear", 2: "eq:quadratictheoryBC", 3: "eq:followercubic_geom"}
    for n, o in enumerate(h.orders, start=1):
        balance = []
        for linear, forcing in zip(o.linear, o.forcing, strict=True):
            rate = _rate(ring, linear)
            balance.append(_equal(expression(ring, rate), expression(ring, rate - linear + forcing)))
        tip = tuple(
            _equal(symbol(jet_name(f, n, 1)), expression(ring, slope))
            for f, slope in zip(FIELDS, o.slopes, strict=True)
        )
        label = f"eq:dynamics{_ADJECTIVE.get(n, n)}"
        yield Object(
            f"balance_{n}", f"balance laws at order {n}, any fields", "hierarchy", label, tuple(balance)
        )
        yield Object(f"tip_{n}", f"tip conditions at order {n}", "hierarchy", tip_labels.get(n, ""), tip)


def _rate(ring: JetRing, linear: PolyElement) -> PolyElement:
    """The drag of a linear row: its terms with a tau-derivative."""
    rates = [g for g in ring.generators_of(linear) if str(g).endswith("_tau")]
    return sum((c * m for m, c in ring.parts(linear, rates).items() if ring.degree(m, rates)), ring.zero)


def _linear_problem(d: Derivation) -> Iterator[Object]:
    rows = _eigenvalue_rows(d, d.modes.ring, I * symbol("omega"), ("Y", "Theta"), d.adjoint.primal)
    yield Object("mode", "eigenvalue problem at the threshold", "harmonics", "eq:primal_eigenproblem", rows)
    e = d.eigenproblem
    if e is None:
        return
    r, y = symbol("r"), symbol("Y")
    polynomial = sum(expression(e.ring, c) * r**k for c, k in zip(e.polynomial, (4, 2, 0), strict=True))
    yield Object(
        "exponents",
        "exponents r of modes exp(r u)",
        "eigenproblem",
        "eq:linearization",
        (_equal(polynomial, _ZERO),),
    )
    ratios = tuple(
        _equal(symbol(s) / y, expression(e.ring, f.numerator) / expression(e.ring, f.denominator))
        for s, f in (("Theta", e.theta), ("H", e.shear))
    )
    title = "amplitude ratios of one exponential"
    yield Object("mode_amplitudes", title, "eigenproblem", "eq:linearization", ratios)


def _eigenvalue_rows(
    d: Derivation,
    ring: JetRing,
    eigenvalue: Expr,
    shapes: tuple[str, str],
    rows: tuple[PolyElement, PolyElement],
) -> tuple[Eq, ...]:
    """eigenvalue Gamma (Y, Theta) = rows."""
    weights = [expression(d.hierarchy.ring, w) for w in d.hierarchy.straight.weights[1:]]
    return tuple(
        _equal(eigenvalue * w * symbol(s), expression(ring, row))
        for s, w, row in zip(shapes, weights, rows, strict=True)
    )


def _second_order(d: Derivation) -> Iterator[Object]:
    ring, jets, order = d.modes.ring, d.hierarchy.ring, d.hierarchy[2]
    f1, b1 = register("f1_2", "f_1^{(2)}"), register("b1_2", "b_1^{(2)}")
    generic = expression(jets, jets.apply(order.forcing[0], _vanishing(d)))
    yield Object(
        "f1_2",
        "forcing of x at order 2: in the fields, and with the ansatz",
        "corrections",
        "eq:longitudinalforcing",
        (_equal(f1, generic), _equal(f1, expression(ring, d.second.forcing))),
    )
    yield Object(
        "b1_2",
        "tip forcing of x' at order 2: in the fields, and with the ansatz",
        "corrections",
        "eq:longitudinalforcingBC",
        (
            _equal(b1, expression(jets, order.slopes[0])),
            _equal(b1, expression(ring, d.second.tip_forcing)),
        ),
    )
    x2 = expression(ring, d.second.modes.fields["x", 2])
    stiffness = homomorphism(d.hierarchy.straight.stiffness[0], {}, ring)
    title = "x at order 2"
    yield Object("x2", title, "corrections", "eq:pdefinitions", (_equal(symbol(jet_name("x", 2, 0)), x2),))
    for c in (d.second.mean, d.second.harmonic):
        x, p = f"X{c.harmonic}", f"P{c.harmonic}"
        tip = register(f"{x}_u_tip", f"X_{c.harmonic}'(1)")
        clamp = register(f"{x}_clamp", f"X_{c.harmonic}(0)")
        elastic = ring.derive(stiffness * ring[f"{x}_u"], "u")
        problem = (
            _equal(expression(ring, elastic), expression(ring, c.drag * c.shape + c.forcing)),
            _equal(clamp, _ZERO),
            _equal(tip, expression(ring, c.tip_slope)),
        )
        yield Object(
            x, "boundary-value problem of a correction", "corrections", "eq:longitudinalODE", problem
        )
        tension = (
            _equal(symbol(p), expression(ring, c.tension)),
            _equal(symbol(f"{p}_u"), expression(ring, c.tension_slope)),
        )
        title = "tension by the constitutive law, and its slope by force balance"
        yield Object(p, title, "corrections", "eq:pdefinitions", tension)


def _vanishing(d: Derivation) -> dict[PolyElement, PolyElement]:
    """Jets of the fields that the solution sets to zero (x1, y2, theta2)."""
    jets = d.hierarchy.ring
    heads = {f"{f}{n}" for (f, n), image in d.second.modes.fields.items() if not image}
    return {g: jets.zero for g in jets.ring.gens if str(g).split("_")[0] in heads}


def _third_order(d: Derivation) -> Iterator[Object]:
    ring, jets, third = d.modes.ring, d.hierarchy.ring, d.third
    known = _vanishing(d)
    for row, name in enumerate(("f2_3", "f3_3")):
        f = register(name, f"f_{row + 2}^{{(3)}}")
        generic = expression(jets, jets.apply(d.hierarchy[3].forcing[row + 1], known))
        equations = [_equal(f, generic)]
        if third.transformed is not None:
            equations.append(_equal(f, _resonant(third.transformed, ring, row)))
        title = "forcing at order 3: of the fields, and the resonant part of the transformed ones"
        yield Object(name, title, "resonance", "eq:cubicforcing", tuple(equations))
    for row, name in enumerate(("t2_3", "t3_3")):
        t = register(name, f"t_{row + 2}^{{(3)}}")
        cubic, detuning, slow = third.traction.cubic, third.traction.detuning, third.traction.slow
        right = _sum_of_terms(*(expression(ring, p[row]) for p in (cubic, detuning, slow)))
        title = "resonant part of what loads the tip at order 3"
        yield Object(name, title, "resonance", "eq:followercubic_stress", (_equal(t, right),))
    if third.transformed is not None:
        yield from _transformed(d, third.transformed)


def _transformed(d: Derivation, t: Transformation) -> Iterator[Object]:
    ring, jets = d.modes.ring, d.hierarchy.ring
    y, theta = (
        register("y3_transformed", r"\tilde{y}^{(3)}"),
        register("theta3_transformed", r"\tilde{\theta}^{(3)}"),
    )
    y_u = register("y3_transformed_u", r"\partial_u\tilde{y}^{(3)}")
    theta_u = register("theta3_transformed_u", r"\partial_u\tilde{\theta}^{(3)}")
    tip_value = {symbol("theta1"): register("theta1_tip", r"\theta^{(1)}(u=1)")}
    rest = expression(jets, t.rest).xreplace(tip_value)
    yield Object(
        "transformed",
        "variables with homogeneous tip conditions at order 3",
        "resonance",
        "eq:cubic_transform",
        (
            _equal(y, symbol("y3") - symbol("u") * rest),
            _equal(theta, symbol("theta3") - expression(jets, t.local)),
        ),
    )
    left = (y_u - symbol("nu") * theta, theta_u)
    conditions = tuple(_equal(a, expression(ring, b)) for a, b in zip(left, t.tip, strict=True))
    title = "tip conditions of the transformed variables"
    yield Object("transformed_tip", title, "resonance", "eq:cubic_transform_free", conditions)
    for k, g in enumerate(t.g, start=1):
        equation = _equal(_forcing_letter(k), expression(ring, g))
        yield Object(f"g{k}", "resonant forcing at order 3", "resonance", "eq:cubicforcing", (equation,))


def _sum_of_terms(cubic: Expr, detuning: Expr, slow: Expr) -> Expr:
    """cubic A^2 A* + detuning Delta A + slow dA/dT, the coefficient of e^{i omega tau}."""
    a, a_bar = symbol("A"), symbol("A" + BAR)
    return a**2 * a_bar * cubic + symbol("Delta") * a * detuning + slow * symbol("A_T")


def _forcing_letter(k: int) -> Symbol:
    return register(f"g{k}", f"g_{k}")


def _resonant(t: Transformation, ring: JetRing, row: int) -> Expr:
    """The resonant forcing with the g's as letters."""
    slow = expression(ring, t.resonant.slow[row])
    return _sum_of_terms(_forcing_letter(2 * row + 1), _forcing_letter(2 * row + 2), slow)


def _adjoint(d: Derivation) -> Iterator[Object]:
    ring, adjoint = d.modes.ring, d.adjoint
    operator = (ring.conjugate(adjoint.operator[0]), ring.conjugate(adjoint.operator[1]))
    rows = _eigenvalue_rows(d, ring, -I * symbol("omega"), ("Psi_Y", "Psi_Theta"), operator)
    yield Object("adjoint", "adjoint eigenvalue problem", "adjoint", "eq:adjoint_eigenproblem", rows)
    for end, conditions in (("clamp", adjoint.clamp), ("tip", adjoint.tip)):
        found = tuple(_equal(expression(ring, c), _ZERO) for c in conditions)
        yield Object(
            f"adjoint_{end}", f"adjoint conditions at the {end}", "adjoint", "eq:adjoint_eigenproblem", found
        )
    q = _equal(register("Q", "Q"), expression(ring, adjoint.concomitant))
    yield Object(
        "concomitant", "Q in Psi^dagger M phi = (M^dagger Psi)^dagger phi + dQ/du", "adjoint", "", (q,)
    )


def _solvability(d: Derivation) -> Iterator[Object]:
    ring, u = d.modes.ring, symbol("u")
    psi_y, psi_theta = symbol("Psi_Y" + BAR), symbol("Psi_Theta" + BAR)
    landau, title = d.landau, "Landau coefficient"
    norm = Integral(expression(ring, landau.norm.integrand), (u, 0, 1)) + expression(
        ring, landau.norm.boundary
    )
    for name, (a, b), kept in (
        ("alpha", (1, 3), landau.cubic_kept),
        ("beta", (2, 4), landau.detuning_kept),
    ):
        if d.third.transformed is not None:
            bulk = Integral(psi_y * _forcing_letter(a) + psi_theta * _forcing_letter(b), (u, 0, 1))
            equation = _equal(symbol(name), bulk / norm)
            described = f"{title}, transformed variables"
            yield Object(name, described, "solvability", "eq:alphabetaformulas", (equation,))
        whole = Integral(expression(ring, kept.integrand), (u, 0, 1)) + expression(ring, kept.boundary)
        equation = _equal(symbol(name), whole / norm)
        yield Object(f"{name}_kept", f"{title}, boundary term kept", "solvability", "", (equation,))
    a, a_bar = symbol("A"), symbol("A" + BAR)
    right = symbol("alpha") * a**2 * a_bar + symbol("beta") * symbol("Delta") * a
    yield Object(
        "stuart_landau", "amplitude equation", "solvability", "eq:SL", (_equal(symbol("A_T"), right),)
    )


def _amplitude(d: Derivation) -> Iterator[Object]:
    a, ring = d.amplitude, d.amplitude.ring

    def ratio(pair: tuple[PolyElement, PolyElement]) -> Expr:
        return expression(ring, pair[0]) / expression(ring, pair[1])

    r_star, rate = register("R_star_squared", "R_*^2"), r"\mathrm{d}\dot{R}/\mathrm{d}R|_{R_*}"
    rows: tuple[tuple[Symbol, str, str, Expr], ...] = (
        (symbol("R_T"), "radial equation", "eq:radial_amplitude", expression(ring, a.radial)),
        (symbol("phi_T"), "phase equation", "eq:phase_amplitude", expression(ring, a.phase)),
        (r_star, "saturated modulus", "eq:saturated_amplitude", ratio(a.saturated)),
        (register("stability", rate), "radial stability at R*", "", expression(ring, a.stability)),
        (register("sigma", r"\sigma"), "slow frequency", "eq:slow_frequency", ratio(a.sigma)),
        (register("A_tip", r"A_{\mathrm{tip}}"), "tip amplitude", "eq:tipamplitude", a.tip_amplitude),
        (register("omega_branch", r"\omega"), "frequency on the branch", "eq:tipfrequency", a.frequency),
    )
    for left, title, label, e in rows:
        yield Object(left.name, title, "amplitude", label, (_equal(left, e),))


def _normal_form(d: Derivation) -> Iterator[Object]:
    """Forcing and traction of every response, and with them the orders beyond the third."""
    for form in (d.normal_form, d.pitchfork):
        if form is None:
            continue
        letter, prefix = ("a", "steady_") if form.steady else ("A", "")
        for r in form.responses:
            p, q, k = r.index
            equations = []
            for kind, rows in (("forcing", r.forcing), ("traction", r.traction)):
                for shape, row in zip(r.shapes, rows, strict=True):
                    name = f"{shape}_{kind}"
                    left = register(name, f"\\mathrm{{{kind}}}[{latex_of(shape)}]")
                    equations.append(_equal(left, expression(form.ring, row)))
            term = f"{letter}^{p} delta^{k}" if form.steady else f"{letter}^{p} {letter}*^{q} delta^{k}"
            title = f"problem of the response to {term}"
            yield Object(prefix + r.shapes[0], title, "anyorder", "eq:hierarchy", tuple(equations))
