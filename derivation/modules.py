"""What is emitted for a rod: which derived formulas become which functions of which modules.

A table of contents, no mathematics: every expression comes from a record of the derivation. Parameters
appear in a signature only where the formula needs them, always in the order of ``_PARAMETERS``.
"""

from __future__ import annotations

from sympy import Expr, sqrt
from sympy.polys.rings import PolyElement

from derivation.eigenproblem import Fraction
from derivation.emit.program import Argument, Function, Module, Package
from derivation.jets import JetRing
from derivation.motion import equations_of_motion
from derivation.pipeline import Derivation
from derivation.present import expression, with_eigenvalue
from derivation.symbols import BAR, SHAPES, symbol

SCALAR = "(...)"
NODES = "(..., nodes)"


def _parameter(name: str, doc: str) -> Argument:
    return Argument(name, symbol(name), doc, SCALAR, parameter=True)


_PARAMETERS = (
    _parameter("k1", "stretch stiffness ratio k1 L^2/k3"),
    _parameter("k2", "shear stiffness ratio k2 L^2/k3"),
    _parameter("gamma3", "rotational drag ratio gamma3/(gamma2 L^2)"),
    _parameter("gamma1", "translational drag ratio gamma1/gamma2"),
    _parameter("force", "follower force F L^2/k3"),
)
_LAM = Argument("lam", symbol("lam"), "i omega at the threshold, purely imaginary", SCALAR, parameter=True)
_EIGENVALUE = Argument("lam", symbol("lam"), "eigenvalue", SCALAR, parameter=True)
_ADJOINT_EIGENVALUE = Argument(
    "lam",
    symbol("lam"),
    "conjugate of the eigenvalue, that is the eigenvalue of the adjoint",
    SCALAR,
    parameter=True,
)


def package(derivation: Derivation) -> Package:
    """All modules of one rod."""
    model = derivation.model
    modules = (
        _rod(derivation),
        _eigenproblem(derivation),
        _second_order(derivation),
        _third_order(derivation),
        _landau(derivation),
        _predictions(derivation),
    )
    return Package(model.name, f"{model.title[0].upper()}{model.title[1:]}.", modules)


def _letters(e: Expr) -> Expr:
    """nu = 1 - force/k1 and mu = k2 nu + force, so that callers pass the five parameters only."""
    k1, k2, force = symbol("k1"), symbol("k2"), symbol("force")
    nu = 1 - force / k1
    return e.xreplace({symbol("nu"): nu, symbol("mu"): k2 * nu + force})


def _field(name: str, doc: str = "", shape: str = NODES) -> Argument:
    return Argument(name, symbol(name), doc or SHAPES[name][1], shape)


def _rod(d: Derivation) -> Module:
    """Exact kinematics and the full nonlinear equations."""
    motion = equations_of_motion(d.model, d.exact)
    jets = {
        "x": "axial position",
        "y": "transverse position",
        "theta": "angle of the frame",
    }

    def jet(name: str) -> Argument:
        f, _, rest = name.partition("_")
        what = {"": "", "u": ", derivative in u", "uu": ", second derivative in u", "t": ", rate of change"}[
            rest
        ]
        return Argument(name, symbol(name), jets[f] + what)

    strain_arguments = tuple(map(jet, ("x_u", "y_u", "theta", "theta_u")))
    rate_arguments = tuple(map(jet, ("theta", "x_t", "y_t", "theta_t")))
    all_jets = ("x_u", "x_uu", "y_u", "y_uu", "theta", "theta_u", "theta_uu")
    strains = tuple(
        _field(n, doc) for n, doc in (("h1", "axial strain"), ("h2", "shear strain"), ("Pi", "curvature"))
    )
    return Module(
        "rod",
        "Exact kinematics, stresses and equations of motion; no angle is assumed small.",
        (
            Function(
                "strains",
                "Strains (h1, h2, Pi) = (e1 . r', e2 . r', e2 . e1').",
                ("eq:definitions",),
                strain_arguments,
                tuple(zip(("h1", "h2", "Pi"), motion.strains, strict=True)),
                namespace=True,
            ),
            Function(
                "velocities",
                "Velocities (v1, v2, Omega) in the moving frame.",
                ("eq:definitions",),
                rate_arguments,
                tuple(zip(("v1", "v2", "Omega"), motion.velocities, strict=True)),
                namespace=True,
            ),
            Function(
                "stresses",
                "Stresses (F1, F2, M), the gradient of the stored energy.",
                ("eq:constitutive",),
                (*strains, *_PARAMETERS),
                tuple(zip(("F1", "F2", "M"), motion.stresses, strict=True)),
            ),
            Function(
                "right_hand_side",
                "Rates (x_t, y_t, theta_t) of the full nonlinear rod in the interior.",
                ("eq:dynamicsfull", "eq:explicitdynamics", "eq:drag"),
                (*map(jet, all_jets), *_PARAMETERS),
                tuple(zip(("x_t", "y_t", "theta_t"), motion.rates, strict=True)),
                namespace=True,
            ),
            Function(
                "tip_residual",
                "Stresses minus load at u = 1; zero on solutions.",
                ("eq:follower",),
                (*strain_arguments, *_PARAMETERS),
                tuple(zip(("F1", "F2", "M"), motion.tip, strict=True)),
                namespace=True,
            ),
        ),
    )


def _eigenproblem(d: Derivation) -> Module:
    e = d.eigenproblem
    ring = e.ring

    def ratio(f: Fraction) -> Expr:
        return _letters(expression(ring, f.numerator) / expression(ring, f.denominator))

    def poly(p: PolyElement) -> Expr:
        return _letters(expression(ring, p))

    r = Argument("r", symbol("r"), "exponent of exp(r u)", SCALAR)
    exp_r = Argument("exp_r", symbol("exp_r"), "exp(r), or any multiple of it that scales the column", SCALAR)
    rows = ("Y_clamp", "Theta_clamp", "H_tip", "Theta_u_tip")
    adjoint_rows = ("Psi_Y_clamp", "Psi_Theta_clamp", "adjoint_shear_tip", "adjoint_moment_tip")
    nu = symbol("nu")
    return Module(
        "eigenproblem",
        "Modes exp(r u): exponents, amplitude ratios, and what each contributes to the boundary conditions.",
        (
            Function(
                "base_state",
                "Stretch nu of the straight rod and mu = k2 nu + force.",
                ("eq:basestate", "eq:linearization"),
                _PARAMETERS,
                (("nu", _letters(nu)), ("mu", _letters(symbol("mu")))),
            ),
            Function(
                "exponent_polynomial",
                "Coefficients (c4, c2, c0) of c4 r^4 + c2 r^2 + c0 = 0 for the exponents r.",
                ("eq:linearization",),
                (_EIGENVALUE, *_PARAMETERS),
                tuple(zip(("c4", "c2", "c0"), map(poly, e.polynomial), strict=True)),
            ),
            _squared_exponents(d),
            Function(
                "mode_amplitudes",
                "Theta/Y and H/Y of one exponential; with the conjugate eigenvalue: Psi_Theta/Psi_Y.",
                ("eq:linearization",),
                (r, _EIGENVALUE, *_PARAMETERS),
                (("theta", ratio(e.theta)), ("shear", ratio(e.shear))),
            ),
            Function(
                "boundary_column",
                "Contributions of one exponential to Y(0), Theta(0), H(1), Theta'(1).",
                ("eq:primal_eigenproblem",),
                (r, exp_r, _EIGENVALUE, *_PARAMETERS),
                tuple(zip(rows, map(ratio, e.column), strict=True)),
            ),
            Function(
                "adjoint_boundary_column",
                "Contributions to Psi_Y(0), Psi_Theta(0), k2 Psi_Y'(1) - mu Psi_Theta(1), "
                "Psi_Theta'(1) + force Psi_Y(1).",
                ("eq:adjoint_eigenproblem",),
                (r, exp_r, _ADJOINT_EIGENVALUE, *_PARAMETERS),
                tuple(zip(adjoint_rows, map(ratio, e.adjoint_column), strict=True)),
            ),
        ),
    )


def _squared_exponents(d: Derivation) -> Function:
    """r1^2 and r2^2, the second from the product of the roots, so that neither is lost by cancellation."""
    e = d.eigenproblem
    c4, c2, c0 = (_letters(expression(e.ring, p)) for p in e.polynomial)
    sign = Argument(
        "sign", symbol("sign"), "+1 or -1: the one that makes -c2 + sign sqrt(disc) the larger", SCALAR
    )
    twice = -c2 + symbol("sign") * sqrt(c2**2 - 4 * c4 * c0)
    return Function(
        "squared_exponents",
        "Squares of the exponents r = +-r1, +-r2.",
        ("eq:linearization",),
        (sign, _EIGENVALUE, *_PARAMETERS),
        (("r1_squared", twice / (2 * c4)), ("r2_squared", 2 * c0 / twice)),
        namespace=True,
    )


#: Arguments that are not shapes themselves.
_DOCS = {
    "Theta_u": "derivative of Theta",
    "Theta_tip": "Theta at u = 1",
    "Psi_Y_tip": "Psi_Y at u = 1",
    "Psi_Theta_tip": "Psi_Theta at u = 1",
    "X0_u": "derivative of X0",
    "X2_u": "derivative of X2",
    "u": "material coordinate",
    "g1": "cubic forcing of the y row",
    "g2": "detuning forcing of the y row",
    "g3": "cubic forcing of the theta row",
    "g4": "detuning forcing of the theta row",
}
#: The order of arguments in a signature.
_ORDER = ("u", "Psi_Y", "Psi_Theta", "Y", "Theta", "Theta_u", "H", "X0_u", "X2_u", "X2", "P0", "P2",
          "Theta_tip", "Psi_Y_tip", "Psi_Theta_tip", "g1", "g2", "g3", "g4")  # fmt: skip


class _Fields:
    """Arguments for a formula over the ring of modes: those that occur, with their conjugates declared."""

    def __init__(self, *expressions: Expr) -> None:
        used = {s.name for e in expressions for s in e.free_symbols}
        plain = {n.replace(BAR, "") for n in used}
        self.arguments = tuple(
            _field(n, _DOCS.get(n, ""), SCALAR if n.endswith("_tip") else NODES) for n in _ORDER if n in plain
        )
        self.conjugates = tuple((symbol(n), symbol(n.replace(BAR, ""))) for n in sorted(used) if BAR in n)


def _function(name: str, doc: str, labels: tuple[str, ...], outputs: dict[str, Expr]) -> Function:
    """A function of mode shapes at the threshold: its arguments are what its formulas contain."""
    fields = _Fields(*outputs.values())
    return Function(
        name, doc, labels, (*fields.arguments, _LAM, *_PARAMETERS), tuple(outputs.items()), fields.conjugates
    )


def _formula(d: Derivation, p: PolyElement) -> Expr:
    """A ring element with i omega as lam, nu and mu eliminated, grouped for reading."""
    ring = d.modes.ring
    return _letters(expression(ring, with_eigenvalue(ring, p)))


def _second_order(d: Derivation) -> Module:
    functions = []
    for c, name in ((d.second.mean, "X0"), (d.second.harmonic, "X2")):
        p = name.replace("X", "P")
        what = "mean" if c.harmonic == 0 else "second-harmonic"
        functions += [
            _function(
                f"{name}_operator",
                f"c in k1 {name}'' = c {name} + forcing, the {what} longitudinal correction.",
                ("eq:longitudinalODE",),
                {"c": _formula(d, c.drag)},
            ),
            _function(
                f"{name}_forcing",
                f"Forcing in k1 {name}'' = c {name} + forcing, with Y'' eliminated.",
                ("eq:longitudinalODE",),
                {"forcing": _formula(d, d.modes.reduce(c.forcing))},
            ),
            _function(
                f"{name}_tip_slope",
                f"{name}'(1); at the clamp {name}(0) = 0.",
                ("eq:ODEBCs",),
                {"slope": _formula(d, c.tip_slope)},
            ),
            _function(
                p,
                f"The {what} tension correction {p} from the constitutive law.",
                ("eq:pdefinitions",),
                {p: _formula(d, c.tension)},
            ),
            _function(
                f"{p}_slope",
                f"{p}' from the axial force balance; {p}(1) = 0. Free of cancellation.",
                ("eq:dynamicsquadratic",),
                {"slope": _formula(d, d.modes.reduce(c.tension_slope))},
            ),
        ]
    return Module(
        "second_order", "Order 2: longitudinal corrections X0, X2 and tensions P0, P2.", tuple(functions)
    )


def _third_order(d: Derivation) -> Module:
    what = ("cubic forcing of the y row", "detuning forcing of the y row",
            "cubic forcing of the theta row", "detuning forcing of the theta row")  # fmt: skip
    return Module(
        "third_order",
        "Order 3: resonant forcings g1 ... g4 of the transformed variables.",
        tuple(
            _function(f"g{k}", f"Resonant {doc}.", ("eq:cubicforcing",), {f"g{k}": _formula(d, g)})
            for k, (g, doc) in enumerate(zip(d.third.g, what, strict=True), start=1)
        ),
    )


def _landau(d: Derivation) -> Module:
    psi = (symbol("Psi_Y" + BAR), symbol("Psi_Theta" + BAR))

    def projected(a: str, b: str) -> dict[str, Expr]:
        return {"integrand": psi[0] * symbol(a) + psi[1] * symbol(b)}

    u1, u2 = d.third.untransformed.cubic, d.third.untransformed.detuning
    norm = _function(
        "norm_integrand",
        "Integrand of the denominator of alpha and beta.",
        ("eq:alphabetaformulas",),
        {"integrand": _formula(d, d.landau.norm.integrand)},
    )
    kept = tuple(
        _function(
            f"{name}_boundary",
            f"Boundary term of the numerator of {name} when the variables of order 3 are left untransformed.",
            ("eq:followercubic_geom",),
            {"boundary": _formula(d, f.boundary)},
        )
        for name, f in (("alpha", d.landau.cubic_kept), ("beta", d.landau.detuning_kept))
    )
    bulk = tuple(
        _function(
            f"{name}_untransformed",
            f"Integrand of the numerator of {name} that goes with {name}_boundary.",
            ("eq:dynamicscubic",),
            {
                "integrand": psi[0] * _formula(d, d.second.modes.reduce(rows[0]))
                + psi[1] * _formula(d, d.second.modes.reduce(rows[1]))
            },
        )
        for name, rows in (("alpha", u1), ("beta", u2))
    )
    return Module(
        "landau",
        "Integrands of the Landau coefficients: alpha = int alpha_integrand / int norm_integrand.\n\n"
        "The pair (x_untransformed, x_boundary) gives the same numerator without transformed variables.",
        (
            norm,
            _function(
                "alpha_integrand",
                "Integrand of the numerator of alpha.",
                ("eq:alphabetaformulas",),
                projected("g1", "g3"),
            ),
            _function(
                "beta_integrand",
                "Integrand of the numerator of beta.",
                ("eq:alphabetaformulas",),
                projected("g2", "g4"),
            ),
            *bulk,
            *kept,
        ),
    )


def _predictions(d: Derivation) -> Module:
    a = d.amplitude
    parts = {n: symbol(n) for n in ("alpha_re", "alpha_im", "beta_re", "beta_im")}
    arguments = tuple(
        Argument(
            n, s, f"{'real' if n.endswith('re') else 'imaginary'} part of {n[:-3]}", SCALAR, parameter=True
        )
        for n, s in parts.items()
    )
    delta = Argument(
        "Delta", symbol("Delta"), "detuning (force - critical force)/epsilon^2", SCALAR, parameter=True
    )
    modulus = Argument("R", symbol("R"), "modulus of the amplitude", SCALAR, parameter=True)
    detuning = Argument("detuning", symbol("detuning"), "force - critical force", SCALAR, parameter=True)
    omega = Argument("omega", symbol("omega"), "critical frequency", SCALAR, parameter=True)
    everything = (modulus, delta, detuning, omega, *arguments)
    ring: JetRing = a.ring

    def ratio(pair: tuple[PolyElement, PolyElement]) -> Expr:
        return expression(ring, pair[0]) / expression(ring, pair[1])

    slope = a.amplitude_slope
    rows: tuple[tuple[str, str, str, Expr], ...] = (
        ("radial_rate", "dR/dT.", "eq:radial_amplitude", expression(ring, a.radial)),
        ("phase_rate", "dphi/dT.", "eq:phase_amplitude", expression(ring, a.phase)),
        (
            "saturated_modulus_squared",
            "R*^2; negative where there is no such solution.",
            "eq:saturated_amplitude",
            ratio(a.saturated),
        ),
        (
            "radial_stability",
            "d(dR/dT)/dR at R*; negative where the branch is stable.",
            "eq:saturated_amplitude",
            expression(ring, a.stability),
        ),
        ("slow_frequency", "sigma, dphi/dT at R*.", "eq:slow_frequency", ratio(a.sigma)),
        (
            "tip_amplitude_squared",
            "A_tip^2; negative where the branch does not exist.",
            "eq:tipamplitude",
            slope * symbol("detuning"),
        ),
        ("frequency", "omega on the branch.", "eq:tipfrequency", a.frequency),
        (
            "tip_amplitude_squared_slope",
            "d(A_tip^2)/d force on the branch at onset.",
            "eq:tipamplitude",
            slope,
        ),
        ("frequency_slope", "d omega/d force on the branch at onset.", "eq:tipfrequency", a.frequency_slope),
    )
    return Module(
        "predictions",
        "The Stuart-Landau equation in polar form and what it predicts near the threshold.",
        tuple(Function(name, doc, (label,), everything, ((name, e),)) for name, doc, label, e in rows),
    )
