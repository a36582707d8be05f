"""How a derived object came about: the steps to it, with what was multiplied and what eliminated.

The sentences are made from the derivation's records: which orders met in a product, which equations
replaced which derivatives.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass

from sympy.polys.rings import PolyElement

from derivation.catalogue import STRAINS, VELOCITIES, Object, objects
from derivation.jets import JetRing
from derivation.pipeline import Derivation

#: What an object is made from; steps of the kinematics are added by rule.
SOURCES: dict[str, tuple[str, ...]] = {
    "balance_1": ("h2_1",),
    "balance_2": ("h1_2", "v1_2"),
    "balance_3": ("h1_2", "h2_3", "v2_3"),
    "tip_1": ("h2_1",),
    "tip_2": ("h1_2", "tip_1"),
    "tip_3": ("h2_3", "tip_2"),
    "mode": ("balance_1", "tip_1"),
    "f1_2": ("balance_2", "mode"),
    "b1_2": ("tip_2",),
    "x2": ("f1_2", "b1_2"),
    "X0": ("x2",),
    "X2": ("x2",),
    "P0": ("h1_2", "X0"),
    "P2": ("h1_2", "X2"),
    "f2_3": ("balance_3", "mode", "x2"),
    "f3_3": ("balance_3", "mode", "x2"),
    "t2_3": ("tip_3", "mode"),
    "t3_3": ("tip_3", "mode"),
    "transformed": ("tip_3",),
    "transformed_tip": ("transformed",),
    **{
        g: ("f2_3" if g in ("g1", "g2") else "f3_3", "transformed", "X0", "X2", "P0", "P2")
        for g in ("g1", "g3")
    },
    **{g: ("f2_3" if g == "g2" else "f3_3", "transformed") for g in ("g2", "g4")},
    "adjoint": ("mode",),
    "adjoint_clamp": ("adjoint",),
    "adjoint_tip": ("adjoint",),
    "concomitant": ("adjoint",),
    "alpha": ("g1", "g3", "adjoint_tip"),
    "beta": ("g2", "g4", "adjoint_tip"),
    "alpha_kept": ("f2_3", "f3_3", "t2_3", "adjoint_tip"),
    "beta_kept": ("f2_3", "f3_3", "t2_3", "adjoint_tip"),
    "stuart_landau": ("alpha", "beta"),
    "R_T": ("stuart_landau",),
    "phi_T": ("stuart_landau",),
    "R_star_squared": ("R_T",),
    "stability": ("R_T", "R_star_squared"),
    "sigma": ("phi_T", "R_star_squared"),
    "A_tip": ("R_star_squared",),
    "omega_branch": ("sigma",),
}


#: Objects that are one thought: they make one step, which stands where the last of them does.
THOUGHTS: tuple[tuple[str, tuple[str, ...]], ...] = (
    ("the exact strains and velocities", (*STRAINS, *VELOCITIES)),
    *(
        (f"order {n}: strains and velocities expanded, put in the balance laws and the tip conditions",
         (*(f"{q}_{n}" for q in (*STRAINS, *VELOCITIES)), f"balance_{n}", f"tip_{n}"))
        for n in (1, 2, 3)
    ),
    ("the mode forces x at order 2", ("f1_2", "b1_2", "x2")),
    ("the two corrections and their tensions", ("X0", "X2", "P0", "P2")),
    ("the forcing of order 3, its tip conditions made homogeneous",
     ("f2_3", "f3_3", "t2_3", "t3_3", "transformed", "transformed_tip")),
    ("the adjoint and its conditions", ("adjoint", "adjoint_clamp", "adjoint_tip", "concomitant")),
)  # fmt: skip


@dataclass(frozen=True)
class Step:
    """One object on the way, and in words how it follows from those before it."""

    object: Object
    because: str


@dataclass(frozen=True)
class Thought:
    """Steps that belong together, in their order; `title` says what they do."""

    title: str
    steps: tuple[Step, ...]


def thoughts(name: str, derivation: Derivation) -> list[Thought]:
    """The steps that lead to an object, grouped; none stands before what it is made from.

    Raises:
        KeyError: if nothing derived is called so.
    """
    steps = {step.object.name: step for step in explain(name, derivation)}
    of = {n: title for title, names in THOUGHTS for n in names}
    groups: dict[str, list[str]] = {}
    for n in steps:
        groups.setdefault(n if n == name else of.get(n, n), []).append(n)
    home = {n: title for title, names in groups.items() for n in names}
    order: dict[str, None] = {}

    def visit(title: str) -> None:
        for n in groups[title]:
            for source in _sources(n):
                if source in home and home[source] not in (title, *order):
                    visit(home[source])
        order[title] = None

    visit(name)
    return [
        Thought(
            title if title not in steps else steps[title].object.title, tuple(steps[n] for n in groups[title])
        )
        for title in order
    ]


def explain(name: str, derivation: Derivation) -> list[Step]:
    """The steps that lead to an object, itself last.

    Raises:
        KeyError: if nothing derived is called so.
    """
    known = objects(derivation)
    if name not in known:
        raise KeyError(name)
    order: dict[str, None] = {}

    def visit(n: str) -> None:
        if n in known and n not in order:
            for source in _sources(n):
                visit(source)
            order[n] = None

    visit(name)
    return [Step(known[n], _because(n, derivation)) for n in order]


def _sources(name: str) -> tuple[str, ...]:
    head, _, n = name.rpartition("_")
    return (head,) if head in (*STRAINS, *VELOCITIES) and n.isdigit() else SOURCES.get(name, ())


def _because(name: str, d: Derivation) -> str:
    head, _, n = name.rpartition("_")
    if name in STRAINS or name in VELOCITIES:
        along = "u" if name in STRAINS else "t"
        pair = {"1": ("e1", "r"), "2": ("e2", "r")}.get(name[-1], ("e2", "e1"))
        frame = "r = (x, y), e1 = (cos, sin), e2 = (-sin, cos)"
        return f"the definition {pair[0]} . d{pair[1]}/d{along} with {frame}"
    if name in ("F1", "F2", "M"):
        along = STRAINS[("F1", "F2", "M").index(name)]
        return f"the derivative of the stored energy along {along}"
    if head in (*STRAINS, *VELOCITIES) and n.isdigit():
        exact = (*d.exact.strains, *d.exact.velocities)[(*STRAINS, *VELOCITIES).index(head)]
        return f"order {n}: {', '.join(_products(exact, int(n)))}, with cos and sin expanded in theta"
    if head == "balance":
        return _balance(int(n))
    if head == "tip":
        return (
            f"order {n} of the tip stresses minus the load, solved for x', y', theta' with the lower orders"
        )
    special = _SPECIAL.get(name)
    return special(d) if special else ""


def _products(exact: PolyElement, n: int) -> Iterator[str]:
    """Which orders of the factors of each product add up to n; cos has even orders, sin odd ones."""
    for monom, _ in exact.terms():
        factors = [str(g) for g, e in zip(exact.ring.gens, monom, strict=True) for _ in range(e)]
        if len(factors) == 1:
            yield _at(factors[0], n)
            continue
        trig, other = sorted(factors, key=lambda f: f not in ("cos", "sin"))
        for k in range(n + 1):
            even = k % 2 == 0 if trig == "cos" else k % 2 == 1
            base = n - k or other == "x_u"  # of the base state only x' = nu is left
            if (k > 1 or even) and base:
                yield f"{_at(trig, k)} {_at(other, n - k)}"


def _at(name: str, n: int) -> str:
    field, _, along = name.partition("_")
    return f"{field}{chr(39) if along == 'u' else '_t' if along else ''}({n})"


def _balance(n: int) -> str:
    """The products of stresses and strains that meet at order n; of the straight rod h1 and F1 are left."""

    def pairs(sign: str, a: str, b: str) -> str:
        orders = range(0 if a == "h1" else 1, n + 1 if b == "F1" else n)
        return "".join(f" {sign} {a}({k}) {b}({n - k})" for k in orders)

    rows = (
        f"F1({n})'{pairs('-', 'Pi', 'F2')}",
        f"F2({n})'{pairs('+', 'Pi', 'F1')}",
        f"M({n})'{pairs('+', 'h1', 'F2')}{pairs('-', 'h2', 'F1')}",
    )
    return f"drag = {'; drag = '.join(rows)}"


def _eliminated(ring: JetRing, p: Iterable[PolyElement], rules: dict[PolyElement, PolyElement]) -> str:
    found = dict.fromkeys(str(g) for q in p for g in ring.generators_of(q) if g in rules)
    names = [x for x in found if "_bar" not in x]
    return ", ".join(names)


def _cubic(name: str) -> Callable[[Derivation], str]:
    def sentence(d: Derivation) -> str:
        modes = d.second.modes
        row = {"g1": 1, "g2": 1, "g3": 2, "g4": 2}[name]
        raw = modes.image(d.hierarchy[3].forcing[row])
        wave = "|A|^2 A" if name in ("g1", "g3") else "Delta A"
        gone = _eliminated(modes.ring, [raw], modes.interior)
        return (
            f"coefficient of {wave} e^(i omega tau) in f{row + 1}_3, minus M on what was subtracted; "
            f"eliminated: {gone} (second derivatives by mode, X0 and X2, X' by P, Y' by H + nu Theta)"
        )

    return sentence


_SPECIAL: dict[str, Callable[[Derivation], str]] = {
    "nu": lambda d: "order 0 of F1 = -force at the tip",
    "mu": lambda d: "the coefficient of theta' in the balance of shear at order 1",
    "mode": lambda d: "y = A Y e^(i omega tau) + c.c., theta = A Theta e^(i omega tau) + c.c. in balance_1",
    "f1_2": lambda d: "what balance_2.1 holds besides order-2 fields, the mode inserted: harmonics 0 and 2",
    "b1_2": lambda d: "what tip_2.1 holds besides order-2 fields, the mode inserted (h2 = theta' = 0 there)",
    "x2": lambda d: (
        "y and theta are not forced at order 2; x has harmonics 0 and 2 and the detuning's -Delta u/k1"
    ),
    "X0": lambda d: "harmonic 0 of balance_2.1 and tip_2.1, the half before + c.c.",
    "X2": lambda d: "harmonic 2 of balance_2.1 and tip_2.1: d/dtau is 2 i omega",
    "P0": lambda d: "harmonic 0 of F1(2) = k1 h1(2), the half before + c.c.",
    "P2": lambda d: "harmonic 2 of F1(2) = k1 h1(2)",
    "f2_3": lambda d: (
        "what balance_3.2 holds besides order-3 fields, x(1) = y(2) = theta(2) = 0, the waves inserted"
    ),
    "f3_3": lambda d: "the same of balance_3.3",
    "transformed": lambda d: (
        "tip_3 is not homogeneous: its part nu theta^3/6 is taken off theta, the rest off y, linearly in u"
    ),
    "transformed_tip": lambda d: "the transformed variables in tip_3",
    **{g: _cubic(g) for g in ("g1", "g2", "g3", "g4")},
    "adjoint": lambda d: "Psi^dagger M phi integrated by parts until no derivative of phi is left",
    "adjoint_clamp": lambda d: "what makes the end terms vanish at u = 0 for every phi that obeys the clamp",
    "adjoint_tip": lambda d: (
        "what makes the end terms vanish at u = 1 for every phi with y' = nu theta, theta' = 0"
    ),
    "alpha": lambda d: "int Psi^dagger f = 0: the coefficient of |A|^2 A over that of dA/dT",
    "beta": lambda d: "int Psi^dagger f = 0: the coefficient of Delta A over that of dA/dT",
    "stuart_landau": lambda d: "the solvability condition solved for dA/dT",
    "R_T": lambda d: "A = R e^(i phi): the real part of dA/dT e^(-i phi)",
    "phi_T": lambda d: "A = R e^(i phi): the imaginary part of dA/dT e^(-i phi), over R",
    "R_star_squared": lambda d: "dR/dT = 0 with R > 0",
    "stability": lambda d: "d(dR/dT)/dR at R*",
    "sigma": lambda d: "dphi/dT at R*",
    "A_tip": lambda d: (
        "the tip moves by 2 epsilon R* Y(1) cos(...), Y(1) = 1, and epsilon^2 Delta = force - critical force"
    ),
    "omega_branch": lambda d: "omega + epsilon^2 sigma with epsilon^2 Delta = force - critical force",
}
