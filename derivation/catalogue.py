"""Every derived object by its name: what ``rodwnl derive --show NAME`` prints and what a verifier compares with.

An object is one or more equations, left-hand side in the paper's letters, right-hand side computed.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from functools import cached_property

from sympy import Eq, Expr, I, Integral, Symbol
from sympy.polys.rings import PolyElement

from derivation.jets import JetRing
from derivation.motion import equations_of_motion
from derivation.pipeline import Derivation
from derivation.present import expression
from derivation.symbols import BAR, FIELDS, jet_name, register, symbol

STRAINS = ("h1", "h2", "Pi")
VELOCITIES = ("v1", "v2", "Omega")
STRESSES = ("F1", "F2", "M")


@dataclass(frozen=True)
class Object:
    """One derived object. ``stage`` is the module that derived it, ``labels`` the paper's."""

    name: str
    title: str
    stage: str
    labels: tuple[str, ...]
    make: Callable[[], tuple[Eq, ...]]

    @cached_property
    def equations(self) -> tuple[Eq, ...]:
        """The equations, computed on first use."""
        return self.make()


def objects(d: Derivation) -> Mapping[str, Object]:
    """All derived objects of a rod, in the order of the derivation."""
    found: dict[str, Object] = {}
    for stage in (_kinematics, _hierarchy, _second_order, _third_order, _adjoint, _solvability, _amplitude):
        for o in stage(d):
            found[o.name] = o
    return found


def _equation(left: Expr, right: Expr) -> Eq:
    return Eq(left, right, evaluate=False)


def _one(left: Expr, ring: JetRing, p: PolyElement) -> Callable[[], tuple[Eq, ...]]:
    return lambda: (_equation(left, expression(ring, p)),)


def _letter(name: str, latex: str) -> Symbol:
    return register(name, latex)


def _graded(name: str, n: int) -> Symbol:
    """h1 at order n: ``h1_3`` in text, h_1^{(3)} in LaTeX."""
    latex = {"Pi": r"\Pi", "Omega": r"\Omega", "M": "M"}.get(name, f"{name[0]}_{name[1:]}")
    return _letter(f"{name}_{n}", f"{latex}^{{({n})}}")


def _kinematics(d: Derivation) -> Iterator[Object]:
    motion = equations_of_motion(d.model, d.exact)
    for names, exact in ((STRAINS, motion.strains), (VELOCITIES, motion.velocities), (STRESSES, motion.stresses)):
        what = {"h1": "exact strain", "v1": "exact velocity", "F1": "stress"}[names[0]]
        label = "eq:constitutive" if names is STRESSES else "eq:definitions"
        for name, e in zip(names, exact, strict=True):
            yield Object(name, what, "kinematics", (label,), lambda n=name, e=e: (_equation(symbol(n), e),))  # type: ignore[misc]
    rates = [symbol(f"{f}_t") for f in FIELDS]
    yield Object(
        "motion", "full nonlinear equations of motion", "motion", ("eq:dynamicsfull",),
        lambda: tuple(_equation(r, e) for r, e in zip(rates, motion.rates, strict=True)),
    )  # fmt: skip
    ring, order = d.kinematics.ring, d.kinematics.order
    suffix = {1: "linear", 2: "quadratic", 3: "cubic"}
    for names, series, kind in ((STRAINS, d.kinematics.strains, "strain"), (VELOCITIES, d.kinematics.velocities, "velocity")):
        for name, s in zip(names, series, strict=True):
            for n in range(1, order + 1):
                left = _graded(name, n)
                yield Object(
                    left.name, f"{kind} at order {n}", "kinematics", (f"eq:{kind}{suffix.get(n, n)}",),
                    _one(left, ring, s[n]),
                )  # fmt: skip


def _hierarchy(d: Derivation) -> Iterator[Object]:
    h, ring = d.hierarchy, d.hierarchy.ring
    yield Object("nu", "stretch of the straight rod", "hierarchy", ("eq:basestate",), _one(symbol("nu"), ring, h.base.nu))
    yield Object("mu", "stiffness of the linear problem", "hierarchy", ("eq:linearization",), _one(symbol("mu"), ring, h.base.mu))
    for n in range(1, d.kinematics.order + 1):
        o = h[n]
        label = {1: "eq:dynamicslinear", 2: "eq:quadratictheory", 3: "eq:dynamicscubic"}.get(n, "")
        yield Object(
            f"balance_{n}", f"balance laws at order {n}, generic fields", "hierarchy", (label,),
            lambda o=o: tuple(  # type: ignore[misc]
                _equation(_rate_term(ring, lin), expression(ring, _rate_part(ring, lin) - lin + f))
                for lin, f in zip(o.linear, o.forcing, strict=True)
            ),
        )  # fmt: skip
        yield Object(
            f"tip_{n}", f"tip conditions at order {n}, generic fields", "hierarchy",
            ({1: "eq:followerlinear", 2: "eq:quadratictheoryBC", 3: "eq:followercubic_geom"}.get(n, ""),),
            lambda o=o: tuple(  # type: ignore[misc]
                _equation(expression(ring, lin), expression(ring, b))
                for lin, b in zip(o.tip_linear, o.tip_forcing, strict=True)
            ),
        )  # fmt: skip
    yield Object(
        "eigenvalue_problem", "linear operator on (Y, Theta) at the threshold", "harmonics",
        ("eq:linearization", "eq:primal_eigenproblem"),
        lambda: tuple(
            _equation(I * symbol("omega") * w * symbol(s), expression(d.modes.ring, row))
            for s, w, row in zip(("Y", "Theta"), (1, symbol("gamma3")), d.adjoint.primal, strict=True)
        ),
    )  # fmt: skip
    e = d.eigenproblem
    r = symbol("r")
    yield Object(
        "exponents", "characteristic polynomial of modes exp(r u)", "eigenproblem", ("eq:linearization",),
        lambda: (_equation(sum(expression(e.ring, c) * r**k for c, k in zip(e.polynomial, (4, 2, 0), strict=True)), 0 * r),),
    )  # fmt: skip
    yield Object(
        "mode_amplitudes", "Theta/Y and H/Y of one exponential", "eigenproblem", ("eq:linearization",),
        lambda: tuple(
            _equation(symbol(s) / symbol("Y"), expression(e.ring, f.numerator) / expression(e.ring, f.denominator))
            for s, f in (("Theta", e.theta), ("H", e.shear))
        ),
    )  # fmt: skip


def _rate_part(ring: JetRing, linear: PolyElement) -> PolyElement:
    """The drag of a linear row: its terms with a tau-derivative."""
    rates = [g for g in ring.generators_of(linear) if str(g).endswith("_tau")]
    return sum((c * m for m, c in ring.parts(linear, rates).items() if ring.degree(m, rates)), ring.zero)


def _rate_term(ring: JetRing, linear: PolyElement) -> Expr:
    return expression(ring, _rate_part(ring, linear))


def _second_order(d: Derivation) -> Iterator[Object]:
    ring = d.modes.ring
    jets = d.hierarchy.ring
    f1 = _letter("f1_2", "f_1^{(2)}")
    b1 = _letter("b1_2", "b_1^{(2)}")
    known = _vanishing(d)
    yield Object(
        "f1_2", "forcing of x at order 2, in the fields and with the ansatz", "corrections", ("eq:longitudinalforcing",),
        lambda: (
            _equation(f1, expression(jets, jets.apply(d.hierarchy[2].forcing[0], known))),
            _equation(f1, expression(ring, d.second.forcing)),
        ),
    )  # fmt: skip
    yield Object(
        "b1_2", "tip forcing of x' at order 2", "corrections", ("eq:longitudinalforcingBC",),
        lambda: (
            _equation(b1, expression(jets, d.hierarchy[2].tip_forcing[0])),
            _equation(b1, expression(ring, d.second.tip_forcing)),
        ),
    )  # fmt: skip
    x2 = symbol(jet_name("x", 2, 0))
    yield Object(
        "x2", "x at order 2", "corrections", ("eq:pdefinitions",),
        lambda: (_equation(x2, expression(ring, d.second.modes.fields["x", 2])),),
    )  # fmt: skip
    for c in (d.second.mean, d.second.harmonic):
        name = f"X{c.harmonic}"
        top = symbol(f"{name}_uu")
        tip = _letter(f"{name}_u_tip", f"X_{c.harmonic}'(1)")
        clamp = _letter(f"{name}_clamp", f"X_{c.harmonic}(0)")
        yield Object(
            name, "boundary-value problem of the longitudinal correction", "corrections",
            ("eq:longitudinalODE", "eq:ODEBCs"),
            lambda c=c, top=top, tip=tip, clamp=clamp: (  # type: ignore[misc]
                _equation(symbol("k1") * top, expression(ring, c.drag * c.shape + c.forcing)),
                _equation(clamp, 0 * top),
                _equation(tip, expression(ring, c.tip_slope)),
            ),
        )  # fmt: skip
        p = symbol(f"P{c.harmonic}")
        slope = symbol(f"P{c.harmonic}_u")
        yield Object(
            p.name, "tension correction: constitutive law, and slope by force balance", "corrections",
            ("eq:pdefinitions",),
            lambda c=c, p=p, slope=slope: (  # type: ignore[misc]
                _equation(p, expression(ring, c.tension)),
                _equation(slope, expression(ring, c.tension_slope)),
            ),
        )  # fmt: skip


def _vanishing(d: Derivation) -> dict[PolyElement, PolyElement]:
    """Jets of the fields that the solution sets to zero (x1, y2, theta2)."""
    jets = d.hierarchy.ring
    heads = {f"{f}{n}" for (f, n), image in d.second.modes.fields.items() if not image}
    return {g: jets.zero for g in jets.ring.gens if str(g).split("_")[0] in heads}


def _third_order(d: Derivation) -> Iterator[Object]:
    ring, jets, t = d.modes.ring, d.hierarchy.ring, d.third
    known = _vanishing(d)
    y3, theta3 = symbol("y3"), symbol("theta3")
    yield Object(
        "transformed", "variables that make the order-3 tip conditions homogeneous", "resonance",
        ("eq:cubic_transform",),
        lambda: (
            _equation(_letter("y3_transformed", r"\tilde{y}^{(3)}"),
                      y3 - symbol("u") * _at_tip(expression(jets, t.rest))),
            _equation(_letter("theta3_transformed", r"\tilde{\theta}^{(3)}"), theta3 - expression(jets, t.local)),
        ),
    )  # fmt: skip
    yield Object(
        "transformed_tip", "tip conditions of the transformed variables", "resonance", ("eq:cubic_transform_free",),
        lambda: tuple(
            _equation(left, expression(ring, b))
            for left, b in zip((
                _letter("y3_transformed_u", r"\partial_u\tilde{y}^{(3)}") - symbol("nu") * symbol("theta3_transformed"),
                _letter("theta3_transformed_u", r"\partial_u\tilde{\theta}^{(3)}"),
            ), t.transformed_tip, strict=True)
        ),
    )  # fmt: skip
    for k, name in ((1, "f2_3"), (2, "f3_3")):
        left = _letter(name, f"f_{k + 1}^{{(3)}}")
        yield Object(
            name, "forcing at order 3 before the transformation, and with it its resonant part", "resonance",
            ("eq:cubicforcing",),
            lambda k=k, left=left: (  # type: ignore[misc]
                _equation(left, expression(jets, jets.apply(d.hierarchy[3].forcing[k], known))),
                _equation(left, _resonant(d, k - 1)),
            ),
        )  # fmt: skip
    for k, g in enumerate(t.g, start=1):
        yield Object(f"g{k}", "resonant forcing at order 3", "resonance", ("eq:cubicforcing",), _one(_letter(f"g{k}", f"g_{k}"), ring, g))


def _at_tip(e: Expr) -> Expr:
    return e.xreplace({symbol("theta1"): _letter("theta1_tip", r"\theta^{(1)}(u=1)")})


def _resonant(d: Derivation, row: int) -> Expr:
    """The coefficient of e^{i omega tau}, with g's as letters."""
    a, a_bar = symbol("A"), symbol("A" + BAR)
    g = [_letter(f"g{k}", f"g_{k}") for k in range(1, 5)]
    slow = expression(d.modes.ring, d.third.resonant.slow[row])
    return a**2 * a_bar * g[2 * row] + symbol("Delta") * a * g[2 * row + 1] + slow * symbol("A_T")


def _adjoint(d: Derivation) -> Iterator[Object]:
    ring, adj = d.modes.ring, d.adjoint
    yield Object(
        "adjoint", "adjoint eigenvalue problem", "adjoint", ("eq:adjoint_eigenproblem",),
        lambda: tuple(
            _equation(-I * symbol("omega") * w * symbol(s), expression(ring, ring.conjugate(row)))
            for s, w, row in zip(("Psi_Y", "Psi_Theta"), (1, symbol("gamma3")), adj.operator, strict=True)
        ),
    )  # fmt: skip
    yield Object(
        "adjoint_clamp", "adjoint conditions at u = 0", "adjoint", ("eq:adjoint_eigenproblem",),
        lambda: tuple(_equation(expression(ring, c), 0 * symbol("u")) for c in adj.clamp),
    )  # fmt: skip
    yield Object(
        "adjoint_tip", "adjoint conditions at u = 1", "adjoint", ("eq:adjoint_eigenproblem",),
        lambda: tuple(_equation(expression(ring, c), 0 * symbol("u")) for c in adj.tip),
    )  # fmt: skip
    yield Object(
        "concomitant", "Q in Psi^dagger M phi = (M^dagger Psi)^dagger phi + dQ/du", "adjoint", (),
        _one(_letter("Q", "Q"), ring, adj.concomitant),
    )  # fmt: skip


def _solvability(d: Derivation) -> Iterator[Object]:
    ring, u = d.modes.ring, symbol("u")

    def integral(e: Expr) -> Expr:
        return Integral(e, (u, 0, 1))

    psi = symbol("Psi_Y" + BAR), symbol("Psi_Theta" + BAR)
    letters = {f"g{k}": _letter(f"g{k}", f"g_{k}") for k in range(1, 5)}
    for name, pair, kept in (("alpha", ("g1", "g3"), d.landau.cubic_kept), ("beta", ("g2", "g4"), d.landau.detuning_kept)):
        bulk = psi[0] * letters[pair[0]] + psi[1] * letters[pair[1]]
        norm = d.landau.norm.integrand
        yield Object(
            name, "Landau coefficient, transformed variables", "solvability", ("eq:alphabetaformulas",),
            lambda name=name, bulk=bulk: (_equation(symbol(name), integral(bulk) / integral(expression(ring, norm))),),  # type: ignore[misc]
        )  # fmt: skip
        yield Object(
            f"{name}_kept", "the same Landau coefficient with the boundary term kept", "solvability", (),
            lambda name=name, kept=kept: (  # type: ignore[misc]
                _equation(symbol(name), (integral(expression(ring, kept.integrand)) + expression(ring, kept.boundary))
                          / integral(expression(ring, norm))),
            ),
        )  # fmt: skip
    a, a_bar = symbol("A"), symbol("A" + BAR)
    yield Object(
        "stuart_landau", "amplitude equation", "solvability", ("eq:SL", "eq:stuart_landau"),
        lambda: (_equation(symbol("A_T"), symbol("alpha") * a**2 * a_bar + symbol("beta") * symbol("Delta") * a),),
    )  # fmt: skip


def _amplitude(d: Derivation) -> Iterator[Object]:
    a = d.amplitude
    ring = a.ring

    def ratio(pair: tuple[PolyElement, PolyElement]) -> Expr:
        return expression(ring, pair[0]) / expression(ring, pair[1])

    rows: tuple[tuple[str, str, str, str, Expr], ...] = (
        ("R_T", "", "radial equation", "eq:radial_amplitude", expression(ring, a.radial)),
        ("phi_T", "", "phase equation", "eq:phase_amplitude", expression(ring, a.phase)),
        ("R_star_squared", "R_*^2", "saturated modulus", "eq:saturated_amplitude", ratio(a.saturated)),
        ("stability", r"\mathrm{d}\dot R/\mathrm{d}R|_{R_*}", "radial stability", "eq:saturated_amplitude",
         expression(ring, a.stability)),
        ("sigma", r"\sigma", "slow frequency", "eq:slow_frequency", ratio(a.sigma)),
        ("A_tip", r"A_{\mathrm{tip}}", "tip amplitude", "eq:tipamplitude", a.tip_amplitude),
        ("omega_branch", r"\omega", "frequency on the branch", "eq:tipfrequency", a.frequency),
    )  # fmt: skip
    for name, latex, title, label, e in rows:
        left = _letter(name, latex) if latex else symbol(name)
        yield Object(name, title, "amplitude", (label,), lambda left=left, e=e: (_equation(left, e),))  # type: ignore[misc]
