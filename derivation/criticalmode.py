r"""The critical mode as a boundary-value problem of first order in u, in real variables.

With H = Y' - nu Theta the rows of M (Y, Theta) = i omega Gamma (Y, Theta) give H' and Theta''; the stresses
minus load vanish at the tip, Y and Theta at the clamp, and Y(1) = 1 (eq:primal_eigenproblem). Real and
imaginary parts are eight functions with ten conditions, so two parameters are unknown: force and omega at
the threshold. Where the rows depend on u it is one more function. Where the stretch of the straight rod is
not given in the force it is one more unknown, and one more function, nu' = -load'/K1, where it varies.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from sympy import Expr, Integer

from derivation.emit.program import Argument, Function, Package
from derivation.signature import needs_namespace, scalar
from derivation.symbols import meaning, symbol

SHAPES = ("Y", "H", "Theta", "Theta_u")
PARTS = ("re", "im")
PLACE = "place"
"""The name of u where it is one of the functions: software for such problems calls all of them u."""

Linear = Mapping[str, Expr]
"""Coefficients by the shape that they multiply; they may contain lam."""


@dataclass(frozen=True)
class BoundaryValueProblem:
    """d states/du = `rates`, and `conditions` on the states at both ends vanish.

    states: their names; functions of u, real. rates, conditions: to be emitted; the first takes the states,
    the second the states with _clamp and _tip behind their names. parameters: those of both. unknowns: the
    parameters that the conditions determine, as many as there are more conditions than states.
    """

    states: tuple[str, ...]
    rates: Function
    conditions: Function
    parameters: tuple[Argument, ...]
    unknowns: tuple[str, ...]


def critical_mode_problem(package: Package) -> BoundaryValueProblem:
    """The problem of a rod's critical mode, from the rows that are emitted for the rod.

    Raises ArithmeticError if a coefficient is not linear in the eigenvalue.
    """
    operator = next(module for module in package.modules if module.name == "operator")
    emitted = {f.name: dict(f.outputs) for f in operator.functions}
    straight, weights = emitted["straight_rod"], emitted["drag_weights"]
    implicit = "nu" not in straight
    nu, u = symbol("nu") if implicit else straight["nu"], symbol("u")
    slope = -straight["compression"].diff(u) / emitted["stretch_stiffness"]["K1"] if implicit else nu.diff(u)
    profile = implicit and slope != 0
    rates = _rates(emitted["y_row"], emitted["theta_row"], weights, nu, slope)
    varies = any(u in c.free_symbols for row in rates.values() for c in row.values())
    states = [f"{shape}_{part}" for shape in SHAPES for part in PARTS] + ["nu"] * profile + [PLACE] * varies

    derivatives = [_part(rates[shape], part) for shape in SHAPES for part in PARTS]
    derivatives += [slope] * profile + [Integer(1)] * varies
    at_tip = {u: Integer(1)} | ({nu: symbol("nu_tip")} if profile else {})
    tip_nu = nu.xreplace(at_tip)
    tips = [_at_tip(emitted[f"{name}_tip_row"], tip_nu) for name in ("y", "theta")]
    conditions = {f"{s}_{p}_at_clamp": symbol(f"{s}_{p}_clamp") for s in ("Y", "Theta") for p in PARTS}
    for name, row in zip(("shear", "moment"), tips, strict=True):
        conditions |= {f"{name}_{p}_at_tip": _part(row, p, "_tip") for p in PARTS}
    conditions |= {"Y_re_at_tip": symbol("Y_re_tip") - 1, "Y_im_at_tip": symbol("Y_im_tip")}
    if varies:
        conditions |= {f"{PLACE}_at_clamp": symbol(f"{PLACE}_clamp")}
    if implicit:
        conditions |= {"balance": straight["balance"].xreplace(at_tip)}

    parameters = _parameters(operator.functions, states)
    ends = [f"{s}_{end}" for end in ("clamp", "tip") for s in states]
    return BoundaryValueProblem(
        tuple(states),
        Function(
            "rates",
            "Derivatives in u of the states.",
            ("eq:primal_eigenproblem",),
            (*(_state(s) for s in states), *parameters),
            tuple(zip((f"{s}_slope" for s in states), derivatives, strict=True)),
            namespace=needs_namespace(derivatives),
        ),
        Function(
            "conditions",
            "What vanishes at the ends.",
            ("eq:primal_eigenproblem",),
            (*(_state(s) for s in ends), *parameters),
            tuple(conditions.items()),
            namespace=needs_namespace(conditions.values()),
        ),
        parameters,
        ("force", "omega", *["nu"] * (implicit and not profile)),
    )


def _rates(y_row: Linear, theta_row: Linear, weights: Linear, nu: Expr, slope: Expr) -> dict[str, Linear]:
    """The derivative of every shape as a linear combination of the shapes; slope: nu'."""
    lam = symbol("lam")
    # Y' = H + nu Theta and Y'' = H' + nu Theta' + nu' Theta; what is left of a row is of first order.

    def lower(row: Linear, shape: str, weight: Expr) -> dict[str, Expr]:
        c = {
            "Y": row["Y"],
            "H": row["Y_u"],
            "Theta": row["Theta"] + nu * row["Y_u"] + slope * row["Y_uu"],
            "Theta_u": row["Theta_u"] + nu * row["Y_uu"],
        }
        return c | {shape: c[shape] - lam * weight}

    first, second = lower(y_row, "Y", weights["y"]), lower(theta_row, "Theta", weights["theta"])
    # a H' + b Theta'' + first = 0,  c H' + d Theta'' + second = 0
    a, b, c, d = y_row["Y_uu"], y_row["Theta_uu"], theta_row["Y_uu"], theta_row["Theta_uu"]
    shear = {s: (b * second[s] - d * first[s]) / (a * d - b * c) for s in SHAPES}
    bending = {s: (c * first[s] - a * second[s]) / (a * d - b * c) for s in SHAPES}
    return {
        "Y": {"H": Integer(1), "Theta": nu},
        "H": {s: e.cancel() for s, e in shear.items()},
        "Theta": {"Theta_u": Integer(1)},
        "Theta_u": {s: e.cancel() for s, e in bending.items()},
    }


def _at_tip(row: Linear, nu: Expr) -> Linear:
    return {
        "Y": row["Y"],
        "H": row["Y_u"],
        "Theta": (row["Theta"] + nu * row["Y_u"]).cancel(),
        "Theta_u": row["Theta_u"],
    }


def _part(row: Linear, part: str, end: str = "") -> Expr:
    """The real or imaginary part at lam = i omega; everything else in the coefficients is real."""
    lam, omega = symbol("lam"), symbol("omega")
    total: Expr = Integer(0)
    for shape, coefficient in row.items():
        still, moving = coefficient.xreplace({lam: Integer(0)}), coefficient.diff(lam)
        if lam in moving.free_symbols:
            raise ArithmeticError(f"the coefficient {coefficient} of {shape} is not linear in the eigenvalue")
        re, im = (symbol(f"{shape}_{p}{end}") for p in PARTS)
        total += still * re - moving * omega * im if part == "re" else still * im + moving * omega * re
    return total


def _state(name: str) -> Argument:
    return Argument(name, symbol("u" if name == PLACE else name), "a state")


def _parameters(functions: tuple[Function, ...], states: list[str]) -> tuple[Argument, ...]:
    """The rod's parameters in their order, then the frequency. Lam, u and states are none of them."""
    others = {"lam", *states, *(f"{name}_tip" for name in states)}
    found = {a.name: a for f in functions for a in f.arguments if a.parameter and a.name not in others}
    return (*found.values(), scalar("omega", meaning("omega")))
