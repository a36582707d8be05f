"""What is emitted for a rod: which derived formulas become which functions of which modules.

A table of contents, no mathematics: every expression comes from a record of the derivation.
"""

from __future__ import annotations

from dataclasses import replace

from sympy import Expr, sqrt
from sympy.polys.rings import PolyElement

from derivation.anyorder import NormalForm
from derivation.eigenproblem import Eigenproblem, Fraction
from derivation.emit.program import Argument, Function, Module, Package
from derivation.motion import equations_of_motion
from derivation.pipeline import Derivation
from derivation.present import expression
from derivation.resonance import Transformation
from derivation.signature import SCALAR, Signatures, needs_namespace, nodal, scalar
from derivation.symbols import BAR, SHAPES, meaning, symbol

_PARTS = (
    *("alpha_re", "alpha_im", "beta_re", "beta_im"),
    *("alpha1_re", "alpha1_im", "alpha5_re", "alpha5_im", "beta2_re", "beta2_im", "third_re"),
)
#: The order through which the modules of a rod are emitted.
EMITTED_ORDER = 5


def package(d: Derivation) -> Package:
    """All modules of one rod."""
    s = Signatures(d)
    modules = [_rod(d, s), _operator(d, s)]
    if d.eigenproblem is not None:
        modules.append(_eigenproblem(d.eigenproblem, s))
    modules.append(_second_order(d, s))
    if d.third.transformed is not None:
        modules.append(_third_order(d.third.transformed, s))
    modules += [_landau(d, s), _normal_form(d.normal_form, s), _predictions(d)]
    if d.pitchfork is not None:
        modules.append(_normal_form(d.pitchfork, s))
    title = d.model.title
    parameters = tuple((p.name, p.default) for p in d.model.parameters)
    return Package(d.model.name, f"{title[0].upper()}{title[1:]}.", tuple(modules), parameters)


def _rod(d: Derivation, s: Signatures) -> Module:
    """Exact kinematics and the full nonlinear equations."""
    motion = equations_of_motion(d.model, d.exact)
    fields = {"x": "axial position", "y": "transverse position", "theta": "angle of the frame"}
    suffixes = {"": "", "u": ", derivative in u", "uu": ", second derivative in u", "t": ", rate of change"}

    def jets(*names: str) -> tuple[Argument, ...]:
        split = [(n, *n.partition("_")[::2]) for n in names]
        return tuple(nodal(n, fields[f] + suffixes[rest]) for n, f, rest in split)

    strain_jets = jets("x_u", "y_u", "theta", "theta_u")
    rate_jets = jets("theta", "x_t", "y_t", "theta_t")
    motion_jets = jets("x_u", "x_uu", "y_u", "y_uu", "theta", "theta_u", "theta_uu")
    tip_jets = (*strain_jets, *rate_jets[1:]) if motion.tip_holds_rates else strain_jets
    strains = (nodal("h1", "axial strain"), nodal("h2", "shear strain"), nodal("Pi", "curvature"))

    def function(
        name: str, doc: str, label: str, arguments: tuple[Argument, ...], outputs: dict[str, Expr]
    ) -> Function:
        namespace = name not in plain or needs_namespace(outputs.values())
        return Function(name, doc, (label,), arguments, tuple(outputs.items()), namespace=namespace)

    def optional(argument: Argument) -> Argument:
        return replace(argument, parameter=True)

    plain = ("stresses", "drag_coefficients", "tip_load", "body_load")
    at_tip = tuple(
        Argument(n, symbol(n), f"{doc} at u = 1", SCALAR, parameter=True)
        for n, doc in (
            ("theta", "angle of the frame"),
            ("v1", "tangential velocity"),
            ("v2", "normal velocity"),
            ("Omega", "angular velocity"),
        )
    )

    def named(names: str, values: tuple[Expr, ...]) -> dict[str, Expr]:
        return dict(zip(names.split(), values, strict=True))

    return Module(
        "rod",
        "Exact kinematics, stresses and equations of motion; no angle is assumed small.",
        (
            function(
                "strains",
                "Strains (h1, h2, Pi) = (e1 . r', e2 . r', e2 . e1').",
                "eq:definitions",
                strain_jets,
                named("h1 h2 Pi", motion.strains),
            ),
            function(
                "velocities",
                "Velocities (v1, v2, Omega) in the moving frame.",
                "eq:definitions",
                rate_jets,
                named("v1 v2 Omega", motion.velocities),
            ),
            function(
                "stresses",
                "Stresses (F1, F2, M), the gradient of the stored energy.",
                "eq:constitutive",
                (*strains, *s.parameters),
                named("F1 F2 M", motion.stresses),
            ),
            function(
                "drag_coefficients",
                "Drag per unit velocity (v1, v2, Omega) and reference length.",
                "eq:drag",
                (*map(optional, strains), *s.parameters),
                named("along_v1 along_v2 along_Omega", motion.drag),
            ),
            function(
                "tip_load",
                "Stresses (F1, F2, M) imposed at u = 1.",
                "eq:follower",
                (*at_tip, *s.parameters),
                named("F1 F2 M", motion.load),
            ),
            function(
                "body_load",
                "Force and moment per reference length beside drag, in the moving frame.",
                "eq:explicitdynamics",
                s.parameters,
                named("b1 b2 m", d.model.body_load),
            ),
            function(
                "right_hand_side",
                "Rates (x_t, y_t, theta_t) of the full nonlinear rod in the interior.",
                "eq:dynamicsfull",
                (*motion_jets, *s.parameters),
                named("x_t y_t theta_t", motion.rates),
            ),
            function(
                "tip_residual",
                "Stresses minus load at u = 1; zero on solutions.",
                "eq:follower",
                (*tip_jets, *s.parameters),
                named("F1 F2 M", motion.tip),
            ),
        ),
    )


def _operator(d: Derivation, s: Signatures) -> Module:
    """The linear problems row by row, for any discretisation in u."""
    ring, straight = d.modes.ring, d.hierarchy.straight
    jets_ring = d.hierarchy.ring

    def coefficients(row: PolyElement, names: tuple[str, ...], at_tip: bool = False) -> dict[str, Expr]:
        return {n: s.formula(row.diff(ring[n]), at_tip) for n in names}

    transverse = ("Y", "Y_u", "Y_uu", "Theta", "Theta_u", "Theta_uu")
    tip_names = ("Y", "Y_u", "Theta", "Theta_u")
    weights = [s.spell(expression(jets_ring, w)) for w in straight.weights]
    k1 = s.spell(expression(jets_ring, straight.stiffness[0]))
    nu, load = (s.spell(expression(jets_ring, p)) for p in (jets_ring["nu"], straight.load))
    balance = s.spell(expression(jets_ring, straight.balance))
    functions = [
        s.function(
            "straight_rod",
            "Stretch nu (where explicit) and compression of the straight rod, and its axial balance, zero.",
            ("eq:basestate",),
            ({} if s.implicit else {"nu": nu}) | {"compression": load, "balance": balance},
        ),
        s.function(
            "drag_weights",
            "Diagonal of Gamma: drag per unit velocity of x, y, theta at the straight rod.",
            ("eq:inner product",),
            {"x": weights[0], "y": weights[1], "theta": weights[2]},
        ),
        s.function("stretch_stiffness", "d2W/dh1^2 at the straight rod.", ("eq:constitutive",), {"K1": k1}),
    ]
    if not d.law.stretch_varies:  # else there is no closed form
        functions.append(
            s.function(
                "detuning_stretch",
                "Derivative in force of the straight rod's position x at a node.",
                ("eq:basestate",),
                {"x": s.formula(d.second.static.diff(ring["Delta"]))},
            )
        )
    x_row, x_tip_row = d.modes.longitudinal_rows(d.hierarchy[1].linear[0], d.hierarchy[1].tip_linear[0])
    problems = (
        ("x", "X2", x_row, x_tip_row, ("X2", "X2_u", "X2_uu"), ("X2", "X2_u")),
        ("y", "(Y, Theta)", d.adjoint.primal[0], d.adjoint.tip_stress[0], transverse, tip_names),
        ("theta", "(Y, Theta)", d.adjoint.primal[1], d.adjoint.tip_stress[1], transverse, tip_names),
    )
    for name, shapes, row, tip, jets, tip_jets in problems:
        functions += [
            s.function(
                f"{name}_row",
                f"Coefficients of the {name} row of the linear operator M on {shapes} and derivatives.",
                ("eq:linearization",),
                coefficients(row, jets),
            ),
            s.function(
                f"{name}_tip_row",
                f"Coefficients of the linear {name} stress minus load at u = 1 on {shapes} and derivatives.",
                ("eq:followerlinear",),
                coefficients(tip, tip_jets, at_tip=True),
            ),
        ]
    return Module(
        "operator",
        "The linear problem row by row: M (Y, Theta) = lam Gamma (Y, Theta), for discretisations in u.",
        tuple(functions),
    )


def _eigenproblem(e: Eigenproblem, s: Signatures) -> Module:
    ring = e.ring
    lam = scalar("lam", "eigenvalue")
    conjugate = scalar("lam", "conjugate of the eigenvalue, that is the eigenvalue of the adjoint")
    r = Argument("r", symbol("r"), "exponent of exp(r u)", SCALAR)
    exp_r = Argument("exp_r", symbol("exp_r"), "exp(r), or any multiple of it that scales the column", SCALAR)
    sign = Argument(
        "sign", symbol("sign"), "+1 or -1: the one that makes -c2 + sign sqrt(disc) the larger", SCALAR
    )

    def ratio(f: Fraction) -> Expr:
        return s.spell(expression(ring, f.numerator) / expression(ring, f.denominator))

    def function(
        name: str, doc: str, label: str, arguments: tuple[Argument, ...], outputs: dict[str, Expr]
    ) -> Function:
        return Function(
            name,
            doc,
            (label,),
            (*arguments, *s.parameters),
            tuple(outputs.items()),
            namespace=sign in arguments or needs_namespace(outputs.values()),
        )

    c4, c2, c0 = (s.spell(expression(ring, p)) for p in e.polynomial)
    # The second root from the product of the roots, so that neither is lost by cancellation.
    twice = -c2 + symbol("sign") * sqrt(c2**2 - 4 * c4 * c0)
    rows = ("Y_clamp", "Theta_clamp", "H_tip", "Theta_u_tip")
    adjoint_rows = ("Psi_Y_clamp", "Psi_Theta_clamp", "adjoint_shear_tip", "adjoint_moment_tip")
    return Module(
        "eigenproblem",
        "Modes exp(r u): exponents, amplitude ratios, and what each contributes to the boundary conditions.",
        (
            function(
                "base_state",
                "Stretch nu of the straight rod and mu = k2 nu + force.",
                "eq:basestate",
                (),
                ({} if s.implicit else {"nu": s.spell(symbol("nu"))}) | {"mu": s.spell(symbol("mu"))},
            ),
            function(
                "exponent_polynomial",
                "Coefficients (c4, c2, c0) of c4 r^4 + c2 r^2 + c0 = 0 for the exponents r.",
                "eq:linearization",
                (lam,),
                {"c4": c4, "c2": c2, "c0": c0},
            ),
            function(
                "squared_exponents",
                "Squares of the exponents r = +-r1, +-r2.",
                "eq:linearization",
                (sign, lam),
                {"r1_squared": twice / (2 * c4), "r2_squared": 2 * c0 / twice},
            ),
            function(
                "mode_amplitudes",
                "Theta/Y and H/Y of one exponential; with the conjugate eigenvalue: Psi_Theta/Psi_Y.",
                "eq:linearization",
                (r, lam),
                {"theta": ratio(e.theta), "shear": ratio(e.shear)},
            ),
            function(
                "boundary_column",
                "Contributions of one exponential to Y(0), Theta(0) and to the tip stresses over their "
                "stiffness: H(1) and Theta'(1) where the load follows.",
                "eq:primal_eigenproblem",
                (r, exp_r, lam),
                dict(zip(rows, map(ratio, e.column), strict=True)),
            ),
            function(
                "adjoint_boundary_column",
                "Contributions to Psi_Y(0), Psi_Theta(0) and to the two adjoint tip conditions: "
                "k2 Psi_Y'(1) - mu Psi_Theta(1) and Psi_Theta'(1) + force Psi_Y(1) where the load follows.",
                "eq:adjoint_eigenproblem",
                (r, exp_r, conjugate),
                dict(zip(adjoint_rows, map(ratio, e.adjoint_column), strict=True)),
            ),
        ),
    )


def _second_order(d: Derivation, s: Signatures) -> Module:
    functions = []
    for c, what in ((d.second.mean, "mean"), (d.second.harmonic, "second-harmonic")):
        x, p = f"X{c.harmonic}", f"P{c.harmonic}"
        tension = f"(K1 {x}')'" if d.law.stretch_varies else f"K1 {x}''"
        functions += [
            s.function(
                f"{x}_operator",
                f"c in {tension} = c {x} + forcing, the {what} longitudinal correction.",
                ("eq:longitudinalODE",),
                {"c": s.formula(c.drag)},
            ),
            s.function(
                f"{x}_forcing",
                f"Forcing in {tension} = c {x} + forcing, with Y'' eliminated.",
                ("eq:longitudinalODE",),
                {"forcing": s.formula(d.modes.reduce(c.forcing))},
            ),
            s.function(
                f"{x}_tip_slope",
                f"{x}'(1); at the clamp {x}(0) = 0.",
                ("eq:ODEBCs",),
                {"slope": s.formula(c.tip_slope, at_tip=True)},
            ),
            s.function(
                p,
                f"The {what} tension correction {p} from the constitutive law.",
                ("eq:pdefinitions",),
                {p: s.formula(c.tension)},
            ),
            s.function(
                f"{p}_slope",
                f"{p}' from the axial force balance. Free of cancellation.",
                ("eq:dynamicsquadratic",),
                {"slope": s.formula(d.modes.reduce(c.tension_slope))},
            ),
            s.function(
                f"{p}_tip",
                f"{p}(1), where {p}_slope is integrated from; 0 where the load follows.",
                ("eq:followerquadratic",),
                {"tension": s.formula(c.tip_tension, at_tip=True)},
            ),
        ]
    return Module(
        "second_order", "Order 2: longitudinal corrections X0, X2 and tensions P0, P2.", tuple(functions)
    )


def _third_order(t: Transformation, s: Signatures) -> Module:
    what = (
        *("cubic forcing of the y row", "detuning forcing of the y row"),
        *("cubic forcing of the theta row", "detuning forcing of the theta row"),
    )
    return Module(
        "third_order",
        "Order 3: resonant forcings g1 ... g4 of the transformed variables.",
        tuple(
            s.function(f"g{k}", f"Resonant {doc}.", ("eq:cubicforcing",), {f"g{k}": s.formula(g)})
            for k, (g, doc) in enumerate(zip(t.g, what, strict=True), start=1)
        ),
    )


def _landau(d: Derivation, s: Signatures) -> Module:
    psi_y, psi_theta = symbol("Psi_Y" + BAR), symbol("Psi_Theta" + BAR)
    landau, third = d.landau, d.third
    functions = [
        s.function(
            "norm_integrand",
            "Integrand of the denominator of alpha and beta.",
            ("eq:alphabetaformulas",),
            {"integrand": s.formula(landau.norm.integrand)},
        ),
        s.function(
            "norm_boundary",
            "What a load with drag at the tip adds to the denominator.",
            ("eq:alphabetaformulas",),
            {"boundary": s.formula(landau.norm.boundary, at_tip=True)},
        ),
    ]
    if third.transformed is not None:
        functions += [
            s.function(
                f"{name}_integrand",
                f"Integrand of the numerator of {name}.",
                ("eq:alphabetaformulas",),
                {"integrand": psi_y * symbol(a) + psi_theta * symbol(b)},
            )
            for name, a, b in (("alpha", "g1", "g3"), ("beta", "g2", "g4"))
        ]
    for name, rows, kept in (
        ("alpha", third.bulk.cubic, landau.cubic_kept),
        ("beta", third.bulk.detuning, landau.detuning_kept),
    ):
        y, theta = (s.formula(d.second.modes.reduce(row)) for row in rows)
        functions += [
            s.function(
                f"{name}_untransformed",
                f"Integrand of the numerator of {name} that goes with {name}_boundary.",
                ("eq:dynamicscubic",),
                {"integrand": psi_y * y + psi_theta * theta},
            ),
            s.function(
                f"{name}_boundary",
                f"Boundary term of the numerator of {name}: what loads the tip at order 3.",
                ("eq:followercubic_stress",),
                {"boundary": s.formula(kept.boundary, at_tip=True)},
            ),
        ]
    return Module(
        "landau",
        "Integrands of the Landau coefficients: alpha = numerator/denominator, beta likewise.\n\n"
        "The denominator is the integral of norm_integrand plus norm_boundary. The numerators are the\n"
        "integrals of x_untransformed plus x_boundary; or, where the load follows, of x_integrand alone.",
        tuple(functions),
    )


def _normal_form(form: NormalForm, s: Signatures) -> Module:
    """The problems of all responses beyond the mode; at a steady crossing their names begin with steady_."""
    ring, prefix = form.ring, "steady_" if form.steady else ""
    fields = {name: f"response {name}" for r in form.responses for name in r.shapes}
    modes = {"Y": SHAPES["Y"][1], "Theta": SHAPES["Theta"][1]}
    suffixes = {"": "", "_u": ", derivative", "_uu": ", second derivative"}
    shapes = [
        nodal(name + suffix, doc + what)
        for name, doc in {**modes, **fields}.items()
        for suffix, what in suffixes.items()
    ]
    rates = [scalar(r.coefficient, f"coefficient {r.coefficient}") for r in form.responses if r.resonant]
    u = nodal("u", "material coordinate")
    functions = []
    for r in form.responses:
        p, q, k = r.index
        what = f"a^{p} delta^{k}" if form.steady else f"A^{p} A*^{q} delta^{k}"
        for kind, rows, place in (("forcing", r.forcing, ""), ("traction", r.traction, ", shapes at u = 1")):
            outputs = {f: s.formula(row, bool(place), ring) for f, row in zip(r.fields, rows, strict=True)}
            functions.append(
                s.function(
                    f"{prefix}{r.shapes[0]}_{kind}",
                    f"{kind.capitalize()} of the response to {what}{place}.",
                    ("eq:hierarchy",),
                    outputs,
                    (u, *shapes, *rates),
                )
            )
    listed = ", ".join("".join(map(str, r.index)) for r in form.responses)
    if form.steady:
        return Module(
            "pitchfork",
            f"Responses Phi_p0r to a^p delta^r at a steady crossing through order {form.order}: {listed}.\n\n"
            "-M Phi = forcing - c_p0r Gamma Phi_100, and tip stresses minus load equal the traction; c_p0r,\n"
            "where p is odd, is the coefficient of a^p delta^r in da/dt. All real.",
            tuple(functions),
        )
    return Module(
        "normal_form",
        f"Responses Phi_pqr to A^p A*^q delta^r through order {form.order}: {listed}.\n\n"
        "((p - q) lam Gamma - M) Phi = forcing - c_pqr Gamma Phi_100, and tip stresses minus load equal the\n"
        "traction; c_pqr, where p = q + 1, is the coefficient of A^p A*^q delta^r in dA/dt.",
        tuple(functions),
    )


def _predictions(d: Derivation) -> Module:
    a, ring = d.amplitude, d.amplitude.ring
    arguments = (
        scalar("R", "modulus of the amplitude"),
        scalar("Delta", "detuning (force - critical force)/epsilon^2"),
        scalar("detuning", "force - critical force"),
        scalar("omega", "critical frequency"),
        *(scalar(name, meaning(name)) for name in _PARTS),
    )

    def ratio(pair: tuple[PolyElement, PolyElement]) -> Expr:
        return expression(ring, pair[0]) / expression(ring, pair[1])

    exists = "negative where the branch does not exist"
    rows: tuple[tuple[str, str, str, Expr], ...] = (
        ("radial_rate", "dR/dT.", "eq:radial_amplitude", expression(ring, a.radial)),
        ("phase_rate", "dphi/dT.", "eq:phase_amplitude", expression(ring, a.phase)),
        ("saturated_modulus_squared", f"R*^2; {exists}.", "eq:saturated_amplitude", ratio(a.saturated)),
        (
            "radial_stability",
            "d(dR/dT)/dR at R*; negative where the branch is stable.",
            "eq:saturated_amplitude",
            expression(ring, a.stability),
        ),
        ("slow_frequency", "sigma, dphi/dT at R*.", "eq:slow_frequency", ratio(a.sigma)),
        (
            "tip_amplitude_squared",
            f"A_tip^2; {exists}.",
            "eq:tipamplitude",
            a.amplitude_slope * symbol("detuning"),
        ),
        ("frequency", "omega on the branch.", "eq:tipfrequency", a.frequency),
        (
            "tip_amplitude_squared_slope",
            "d(A_tip^2)/d force on the branch at onset.",
            "eq:tipamplitude",
            a.amplitude_slope,
        ),
        ("frequency_slope", "d omega/d force on the branch at onset.", "eq:tipfrequency", a.frequency_slope),
        (
            "tip_amplitude_squared_curvature",
            "Coefficient of (force - critical force)^2 in A_tip^2.",
            "eq:tipamplitude",
            a.amplitude_curvature,
        ),
        (
            "frequency_curvature",
            "Coefficient of (force - critical force)^2 in omega.",
            "eq:tipfrequency",
            a.frequency_curvature,
        ),
        (
            "fold_modulus_squared",
            "R^2 at a fold of the branch; negative where there is none.",
            "eq:radial_amplitude",
            a.fold_modulus_squared,
        ),
    )
    fold = Function(
        "fold_polynomial",
        "Coefficients (c2, c1, c0) of c2 d^2 + c1 d + c0 = 0 for the detuning d of a fold of the branch.",
        ("eq:radial_amplitude",),
        arguments,
        tuple(zip(("c2", "c1", "c0"), a.fold_polynomial, strict=True)),
    )
    return Module(
        "predictions",
        "The Stuart-Landau equation in polar form and what it predicts near the threshold.",
        (*(Function(name, doc, (label,), arguments, ((name, e),)) for name, doc, label, e in rows), fold),
    )
