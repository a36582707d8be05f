r"""A model expanded about the straight rod: stresses, drag and loads as polynomials in small quantities.

The straight rod has strains (nu, 0, 0). With s = h1 - nu the energy is its Taylor polynomial in (s, h2, Pi),
the drag coefficients theirs, the tip load its own in theta and the velocities. Taylor coefficients that are
polynomials in the parameters and nu enter as they are; the second derivatives K1, K2, K3 of the energy get a
letter of their own unless they are a lone parameter; anything else becomes a named constant whose formula
is kept for evaluation. Where nu varies along the rod so do they: the derivative of a Taylor coefficient in nu
is the next one, c_ijk' = (i + 1) c_(i+1)jk.

Assumptions of the theory are checked here, on the data: reflection symmetry (theta, y) -> (-theta, -y), no
coupling of shear and bending at the straight rod, drag along its own direction.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import product
from math import prod

from sympy import Expr, Integer, Poly, Symbol, factorial, nan, oo, zoo
from sympy import cos as cosine
from sympy import sin as sine

from derivation.errors import ModelError
from derivation.model import RodModel
from derivation.symbols import STRAIGHT, register, symbol

STRAINS = ("h1", "h2", "Pi")
SHIFTED = ("stretch", "h2", "Pi")
VELOCITIES = ("v1", "v2", "Omega")
BASIC = ("k1", "k2", "gamma1", "gamma3", "force")


@dataclass(frozen=True)
class Constitution:
    """The expanded model.

    Attributes:
        stresses: (F1, F2, M) as polynomials in (stretch, h2, Pi), the base value of F1 left out.
        axial: F1 of the straight rod as a function of nu.
        drag: polynomials in (stretch, h2, Pi) times the velocities.
        tip_load, body_load: polynomials in (theta, v1, v2, Omega, force) and force.
        stiffness: the letters of (K1, K2, K3), 1 where it is one.
        inverses: letter -> name of its inverse.
        constants: name -> formula in the parameters and nu, for every letter that is not a parameter.
        slopes: name of such a letter -> its derivative in nu, where nu varies; None beyond what is derived.
        parameters: all parameters of the model, in order.
        uniform: whether nu is the same at every u.
    """

    stresses: tuple[Expr, Expr, Expr]
    axial: Expr
    drag: tuple[Expr, Expr, Expr]
    tip_load: tuple[Expr, Expr, Expr]
    body_load: tuple[Expr, Expr, Expr]
    stiffness: tuple[Expr, Expr, Expr]
    inverses: dict[str, str]
    constants: dict[str, Expr]
    slopes: dict[str, Expr | None]
    parameters: tuple[str, ...]
    uniform: bool

    @property
    def compliance(self) -> tuple[Expr, ...]:
        """The letters of 1/K1, 1/K2, 1/K3."""
        return tuple(symbol(self.inverses[str(k)]) if k != 1 else Integer(1) for k in self.stiffness)

    @property
    def stretch_varies(self) -> bool:
        """Whether K1 is another at every u."""
        return self.slopes.get(str(self.stiffness[0]), Integer(0)) != 0

    @property
    def may_buckle(self) -> bool:
        """Whether a steady crossing is possible: not where the tip load does not depend on theta.

        At lambda = 0 the stresses of a perturbation then vanish at the tip and solve a homogeneous initial
        value problem from there, so they vanish, and so does the perturbation.
        """
        return any(symbol("theta") in load.free_symbols for load in self.tip_load)


def expand_model(model: RodModel, order: int) -> Constitution:
    """Taylor polynomials of a model to what ``order`` needs.

    Raises:
        ModelError: if the model breaks an assumption of the theory; the message says which and where.
    """
    letters = _Letters(model)
    _require_known(model, letters.parameters)
    energy = _taylor(model.energy, order + 1)
    _require_reflection(model, energy)
    stiffness = []
    for k, name in enumerate(("K1", "K2", "K3")):
        index = tuple(2 * (j == k) for j in range(3))
        stiffness.append(letters.stiffness(name, index, 2 * energy.get(index, Integer(0))))
    if energy.get((0, 1, 1), Integer(0)) != 0:
        raise ModelError(
            f"{model.name}: the energy couples shear and bending at the straight rod (a term h2 Pi); "
            "the theory here needs W without it"
        )
    named = {index: letters.taylor("W", index, c) for index, c in energy.items() if sum(index) > 1}
    shifted = [symbol(q) for q in SHIFTED]
    w = sum((c * _monomial(index) for index, c in named.items()), Integer(0))
    drag = tuple(_drag(model, letters, k, order) for k in range(3))
    tip = tuple(_tip(model, letters, k, order) for k in range(3))
    along, *across = model.body_load
    if along.free_symbols - {symbol("force")} or not is_rational(along) or across != [0, 0]:
        raise ModelError(
            f"{model.name}: a body load must be a tangential force, a rational number times force"
        )
    uniform = model.body_load[0] == 0
    _require_compression(model, tip, uniform)
    _require_mirrored(model)
    axial = letters.taylor("W", (1, 0, 0), energy.get((1, 0, 0), Integer(0)))
    return Constitution(
        tuple(w.diff(s).expand() for s in shifted),
        axial,
        drag,
        tip,
        model.body_load,
        tuple(stiffness),
        letters.inverses,
        letters.constants,
        {} if uniform else letters.slopes(),
        letters.parameters,
        uniform,
    )


def multiplied_out(e: Expr) -> Expr:
    """Products over sums, but exp(a + b) as it is: it would fall apart into a constant and a function."""
    return e.expand(power_exp=False, power_base=False, log=False)


#: W or the drag C1, C2, C3, and exponents of (stretch, h2, Pi).
Place = tuple[str, tuple[int, ...]]


class _Letters:
    """Hands out letters for coefficients and remembers what they stand for."""

    def __init__(self, model: RodModel) -> None:
        self.model = model
        self.parameters = (*BASIC, *(p.name for p in model.parameters))
        self.constants: dict[str, Expr] = {}
        self.inverses: dict[str, str] = {}
        self._known: dict[Place, Expr] = {}

    def stiffness(self, name: str, index: tuple[int, ...], value: Expr) -> Expr:
        value = multiplied_out(value)
        if value == 0:
            raise ModelError(
                f"{self.model.name}: {STRAIGHT[name][1]} is zero: the energy is not convex there"
            )
        letter = value
        if value != 1:
            if not isinstance(value, Symbol):
                letter = symbol(name)
                self.constants[name] = value
            self.inverses[letter.name] = f"{letter.name}_inv"
        self._known["W", index] = letter / 2
        return letter

    def taylor(self, kind: str, index: tuple[int, ...], value: Expr) -> Expr:
        """The Taylor coefficient of these exponents in (stretch, h2, Pi), as the ring holds it."""
        place = kind, index
        if place not in self._known:
            self._known[place] = self.coefficient(kind, index, value)
        return self._known[place]

    def slopes(self) -> dict[str, Expr | None]:
        """d/dnu of every constant; None for the letters that only this brings in."""
        nu = symbol("nu")
        found: dict[str, Expr | None] = {name: e.diff(nu) for name, e in self.constants.items()}
        for (kind, (i, *rest)), c in list(self._known.items()):
            factor, letter = c.as_coeff_Mul()
            if slope := found.get(str(letter)):
                following = self.taylor(kind, (i + 1, *rest), slope * factor / (i + 1))
                found[str(letter)] = (i + 1) * following / factor
        return {name: found.get(name) for name in self.constants}

    def coefficient(self, kind: str, index: tuple[int, ...], value: Expr) -> Expr:
        """The coefficient itself if the ring can hold it, else a constant ``kind_ijk``."""
        nu = symbol("nu")
        value = multiplied_out(value)
        if is_rational(value):
            return value
        numerator, denominator = value.together().as_numer_denom()
        inverse = denominator.free_symbols == {nu} and is_rational(denominator)
        power = Poly(denominator, nu).as_dict() if inverse else {}
        if len(power) == 1 and is_rational(numerator):
            (((exponent,), factor),) = power.items()
            self.inverses["nu"] = "nu_inv"
            return (numerator / factor).expand() * symbol("nu_inv") ** exponent
        name = f"{kind}_{''.join(map(str, index))}"
        register(name, f"{kind}_{{{''.join(map(str, index))}}}")
        self.constants[name] = value
        return symbol(name)


def _require_known(model: RodModel, parameters: tuple[str, ...]) -> None:
    """Each formula is in its own quantities and the declared parameters."""
    frame = ("theta", "cos", "sin")
    places = (
        ("the energy", STRAINS, (model.energy,)),
        ("the drag", (*STRAINS, *VELOCITIES), model.drag),
        ("the tip load", ("force", *frame, *VELOCITIES), model.tip_load),
        ("the body load", ("force",), model.body_load),
    )
    for place, quantities, formulas in places:
        own = (name for name in parameters if name != "force")  # the detuning acts on loads alone
        allowed = {symbol(name) for name in (*quantities, *own)}
        for formula in formulas:
            if strange := sorted(s.name for s in formula.free_symbols - allowed):
                raise ModelError(
                    f"{model.name}: unknown symbol {', '.join(strange)} in {place}; it may hold "
                    f"{', '.join(s.name for s in sorted(allowed, key=str))} and parameters that are declared"
                )


def _require_compression(model: RodModel, tip: tuple[Expr, ...], uniform: bool) -> None:
    """The straight rod at rest carries ``force`` at its tip, or nothing under a distributed load."""
    still = {symbol(q): Integer(0) for q in ("theta", *VELOCITIES)}
    f1, f2, m = (load.xreplace(still) for load in tip)
    wanted = -symbol("force") if uniform else Integer(0)
    if (f1 - wanted).expand() != 0 or f2 != 0 or m != 0:
        raise ModelError(
            f"{model.name}: at rest and straight the tip load is ({f1}, {f2}, {m}), but it must be "
            + ("(-force, 0, 0)" if uniform else "(0, 0, 0) beside a distributed load")
        )


def _require_mirrored(model: RodModel) -> None:
    """Reflection keeps F1 of the tip load and turns the signs of F2 and M."""
    turned = {symbol(q): -symbol(q) for q in ("theta", "v2", "Omega", "sin")}
    for name, sign, load in zip(("F1", "F2", "M"), (1, -1, -1), model.tip_load, strict=True):
        if multiplied_out(load - sign * load.xreplace(turned)) != 0:
            raise ModelError(
                f"{model.name}: the tip load {name} is not symmetric under reflection: under (theta, v2, "
                "Omega) -> (-theta, -v2, -Omega) F1 must stay and F2 and M change their signs"
            )


def _taylor(f: Expr, degree: int) -> dict[tuple[int, ...], Expr]:
    """Taylor coefficients of f(h1, h2, Pi) at (nu, 0, 0): exponents -> coefficient."""
    at = {symbol("h1"): symbol("nu"), symbol("h2"): Integer(0), symbol("Pi"): Integer(0)}
    found: dict[tuple[int, ...], Expr] = {}
    for index in product(range(degree + 1), repeat=3):
        if sum(index) > degree:
            continue
        derivative = f
        for q, n in zip(STRAINS, index, strict=True):
            derivative = derivative.diff(symbol(q), n) if n else derivative
        value = multiplied_out(_positive_root(derivative.subs(at, simultaneous=True)))
        if value.has(nan, zoo, oo):
            raise ModelError(
                f"{f} is not smooth at the straight rod: a derivative of it does not exist there"
            )
        value = value / (factorial(index[0]) * factorial(index[1]) * factorial(index[2]))
        if value != 0:
            found[index] = value
    return found


def _positive_root(value: Expr) -> Expr:
    """sqrt(nu^2) is nu: the straight rod has positive length."""
    from sympy import Dummy, powdenest

    nu, positive = symbol("nu"), Dummy(positive=True)
    return powdenest(value.xreplace({nu: positive}), force=False).xreplace({positive: nu})


def _monomial(index: tuple[int, ...]) -> Expr:
    out: Expr = Integer(1)
    for q, n in zip(SHIFTED, index, strict=True):
        out *= symbol(q) ** n
    return out


def _require_reflection(model: RodModel, energy: dict[tuple[int, ...], Expr]) -> None:
    for index in energy:
        if (index[1] + index[2]) % 2:
            raise ModelError(
                f"{model.name}: the energy is not symmetric under reflection (h2, Pi) -> (-h2, -Pi): "
                f"it has a term h1^{index[0]} h2^{index[1]} Pi^{index[2]} at the straight rod"
            )


def _drag(model: RodModel, letters: _Letters, k: int, order: int) -> Expr:
    velocity = symbol(VELOCITIES[k])
    coefficient = model.drag[k].diff(velocity)
    if (model.drag[k] - coefficient * velocity).expand() != 0 or coefficient.free_symbols & set(
        map(symbol, VELOCITIES)
    ):
        raise ModelError(
            f"{model.name}: drag component {k + 1} is not {velocity} times a function of the strains"
        )
    terms = _taylor(coefficient, order - 1)
    for index in terms:
        if (index[1] + index[2]) % 2:
            raise ModelError(f"{model.name}: drag component {k + 1} is not symmetric under reflection")
    if (0, 0, 0) not in terms:
        raise ModelError(
            f"{model.name}: drag component {k + 1} vanishes at the straight rod; it must be positive"
        )
    parts = (letters.taylor(f"C{k + 1}", index, c) * _monomial(index) for index, c in terms.items())
    return sum(parts, Integer(0)) * velocity


def is_rational(e: Expr) -> bool:
    """Whether this is a polynomial in all its symbols with rational coefficients: what a ring can hold."""
    symbols = sorted(e.free_symbols, key=str)
    if not symbols:
        return bool(e.is_Rational)
    return bool(e.is_polynomial(*symbols)) and all(c.is_Rational for c in Poly(e, *symbols).coeffs())


def _tip(model: RodModel, letters: _Letters, k: int, order: int) -> Expr:
    """Taylor polynomial of a tip load in theta; it must be one in the velocities and the force already."""
    theta = symbol("theta")
    load = model.tip_load[k].xreplace({symbol("cos"): cosine(theta), symbol("sin"): sine(theta)})
    total: Expr = Integer(0)
    for n in range(order + 1):
        total += load.subs(theta, 0) * theta**n / factorial(n)
        load = load.diff(theta)
    total = total.expand()
    if is_rational(total):
        return total
    small = [symbol(q) for q in (*VELOCITIES, "force", "theta")]
    if not total.is_polynomial(*small):
        raise ModelError(
            f"{model.name}: the tip load {('F1', 'F2', 'M')[k]} must be a polynomial in v1, v2, Omega and "
            "force, with a Taylor polynomial in theta"
        )
    return sum(
        (
            letters.coefficient(f"L{k + 1}", index, c) * prod(s**e for s, e in zip(small, index, strict=True))
            for index, c in Poly(total, *small).as_dict().items()
        ),
        Integer(0),
    )
