"""What a letter stands for in an equation: that may depend on what else occurs there.

A letter without tilde has its dimensions where no scaled letter occurs; the force is the critical one unless
the equation tells the two apart; xi is the field or the mode. All of it is read off the equation itself.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field
from functools import cached_property

from derivation.paper.algebra import Atom, I, Poly, atom, constant, exp, poly
from derivation.paper.meanings import FIELDS, LOADS, ORDERS, STRAINS, STRESSES, VELOCITIES, integral
from derivation.paper.notation import Notation
from derivation.paper.reasons import UndecidedError, UnfitError
from derivation.paper.syntax import (
    Apply,
    At,
    Diff,
    Equation,
    Node,
    Num,
    Prime,
    Relation,
    Sym,
    children,
    walk,
)  # fmt: skip
from derivation.paper.theory import Theory
from derivation.paper.values import Array, Value

#: Dimensions in (L, k3, gamma2): what a quantity is divided by when it is made dimensionless.
UNITS: dict[str, tuple[int, int, int]] = {
    **dict.fromkeys(("x", "y", "u", "length"), (1, 0, 0)),
    **dict.fromkeys(("theta", "h1", "h2"), (0, 0, 0)),
    "Pi": (-1, 0, 0),
    "t": (4, -1, 1),
    **dict.fromkeys(("v1", "v2"), (-3, 1, -1)),
    "Omega": (-4, 1, -1),
    **dict.fromkeys(("F1", "F2", "k1", "k2", "force"), (-2, 1, 0)),
    "M": (-1, 1, 0),
    **dict.fromkeys(("f1", "f2"), (-3, 1, 0)),
    "m": (-2, 1, 0),
    "energy": (-1, 1, 0),
    **dict.fromkeys(("gamma1", "gamma2"), (0, 0, 1)),
    "gamma3": (2, 0, 1),
    "k3": (0, 1, 0),
}
SCALED = ("k1", "k2", "gamma1", "gamma3", "force", "force_c")
CONSTANTS = {
    "k1", "k2", "gamma1", "gamma3", "nu", "mu", "epsilon", "Delta", "delta", "alpha", "beta", "R", "R_star",
    "phase", "phase_0", "sigma", "A_tip",
}  # fmt: skip
SHAPES = ("Y", "Theta", "X0", "X2", "Psi_Y", "Psi_Theta")
COORDINATES = ("u", "t", "tau", "T", "length")


@dataclass
class Letters:
    """One equation and what its letters stand for in it.

    Attributes:
        indices: values of order letters (``n``) and of summed indices.
        left_out: what the equation leaves unsaid: "nst", "dots", or the power from which terms are dropped.
    """

    equation: Equation
    notation: Notation
    theory: Theory
    indices: dict[str, int] = field(default_factory=dict)
    left_out: set[str] = field(default_factory=set)

    # What kind of equation it is: read off the quantities that occur in it.

    @cached_property
    def quantities(self) -> set[tuple[str, str]]:
        """(quantity, order) of every letter."""
        return {(q, s.order) for s in self._letters() if (q := self.quantity_of(s)[0])}

    @cached_property
    def names(self) -> set[str]:
        return {q for q, _ in self.quantities}

    @cached_property
    def dimensional(self) -> bool:
        """Letters with their dimensions: no scaled letter occurs, or a scaled letter is defined."""
        if any(order for _, order in self.quantities) or self.names & {"A", "xi", "Psi"}:
            return False
        if "R_star" in self.names:
            return False
        rest: set[str] = set(self.names)
        body = self.equation.body
        if (
            isinstance(body, Relation)
            and isinstance(body.left, Sym)
            and self.quantity_of(body.left)[0] in SCALED
        ):
            found = (self.quantity_of(s)[0] for s in walk(body.right) if isinstance(s, Sym))
            rest = {q for q in found if q}
        measured = {q for q in rest if q.endswith("_dim") or (q in UNITS and q not in ("u", "t"))}
        return bool(measured) and not set(SCALED) & rest

    @cached_property
    def place(self) -> int | None:
        if self.where is None:
            return None
        if not (isinstance(self.where.left, Sym) and self.quantity_of(self.where.left)[0] == "u"):
            raise UndecidedError("a place that is not one along the rod")
        return self.end(self.where.right)

    @property
    def where(self) -> Relation | None:
        """The place that the equation gives, or the sentence before it for a condition."""
        return self.equation.place or (self.equation.said if self._is_condition else None)

    @property
    def _is_condition(self) -> bool:
        """A place that the text alone gives counts for conditions: the left side is of no higher order than
        one in u, and the equation itself evaluates no letter there."""
        body = self.equation.body
        if not isinstance(body, Relation):
            return False
        numbers = (
            a for n in walk(body.left) if isinstance(n, Apply) for a in n.args if not isinstance(a, Sym)
        )
        evaluated = any(True for _ in numbers) or any(isinstance(n, At) for n in walk(body.left))
        return not evaluated and max(map(derivatives, (body.left, body.right))) <= 1

    @cached_property
    def free(self) -> tuple[str, ...]:
        """Index letters of the left side."""
        body = self.equation.body
        found: list[str] = []
        if isinstance(body, Relation):
            for s in walk(body.left):
                if isinstance(s, Sym):
                    found += [i for i in self.quantity_of(s)[1] if i not in found]
        return tuple(found)

    def _letters(self) -> Iterator[Sym]:
        return (s for s in walk(self.equation.body) if isinstance(s, Sym))

    def quantity_of(self, s: Sym) -> tuple[str | None, tuple[str, ...]]:
        """What a letter stands for, and its index letters."""
        q = self.notation.quantity(s.name)
        if q is not None:
            return q, ()
        split = tuple(f"\\{part}" for part in s.sub.split("\\")[1:])
        q = self.notation.quantity(s.base)
        if q in ("xi", "L") and split and set(split) <= {"\\alpha", "\\beta"}:
            return q, split
        return None, ()

    @cached_property
    def is_exact(self) -> bool:
        return not any(order for _, order in self.quantities) and not self.names & {"xi", "A", "Y"}

    def end(self, node: Node) -> int:
        if isinstance(node, Sym) and self.quantity_of(node)[0] == "length":
            return 1
        if isinstance(node, Num) and node.value in (0, 1):
            return int(node.value)
        raise UndecidedError("a place that is neither end of the rod")

    def _sym(self, s: Sym) -> Value:
        q, index = self.quantity_of(s)
        if q is None and s.name in self.indices:
            return poly(self.indices[s.name])
        if q is None:
            raise UndecidedError(f"the notation does not say what {s.name} is")
        if index:
            return self._component(q, s, index)
        if s.order:
            return self._of_order(q, s)
        if q.endswith("_dim") or (q in UNITS and q not in SCALED):
            return self._measured(q.removesuffix("_dim"))
        simple = self._simple(q)
        if simple is not None:
            return simple
        vector = self._vector(q)
        if vector is not None:
            return tuple(row if isinstance(row, tuple) else (row,) for row in vector)
        raise UnfitError(f"{s.name} has no meaning on its own")

    def _of_order(self, q: str, s: Sym) -> Value:
        n = int(s.order) if s.order.isdigit() else self.indices.get(s.order)
        if n is None:
            raise UndecidedError(f"the order {s.order} is not bound")
        if n not in (0, *ORDERS):
            raise UndecidedError(f"order {n} of {s.name}: the theory has the orders 0 to {ORDERS[-1]}")
        hatted = s.order.isdigit()  # the general order n speaks of the variables as they are
        hats = ("x", "y_hat", "theta_hat") if n == 3 and hatted else FIELDS
        components = {"xi": hats, "forcing": ("f1", "f2", "f3")}.get(q, (q,))
        if q == "any":
            return atom(Atom("exact", f"any_{n}"))
        values = [self.theory.of_order(c, n, transformed=hatted) for c in components]
        found = tuple((v,) for v in values if v is not None)
        if len(found) < len(values):
            raise UnfitError(f"{s.name} has no order {n}")
        return found[0][0] if q in components else found

    def _component(self, q: str, s: Sym, index: tuple[str, ...]) -> Poly:
        if not set(index) <= set(self.indices):
            raise UnfitError(f"an index of {s.base} stands once and is not on the left")
        places = [self.indices[i] for i in index]
        array = self._vector(q)
        try:
            return array[places[0]] if q == "xi" else array[places[0]][places[1]]  # type: ignore[index,return-value]
        except (IndexError, TypeError):
            raise UnfitError(f"{s.base} has another number of indices") from None

    def _measured(self, q: str) -> Value:
        """Letters that have dimensions: fields and parameters before scaling."""
        scale = self.scale(q)
        if q in ("k3", "gamma2", "length"):
            return scale if q != "length" else self.scale("u")
        if q == "u":
            return constant("u") * scale
        if q == "t":
            return constant("t") * scale
        if q in FIELDS and self.leading:
            return constant("epsilon") * atom(Atom("field", q, 1))
        if q in (*STRAINS, *VELOCITIES) and self.names & {"r", "e1", "e2"}:
            return self.theory.kinematics(q) * scale
        if q in LOADS:
            return self.theory.body_force[LOADS.index(q)] * scale
        if q == "energy":
            return integral(self.theory.energy) * scale
        if q == "force":
            return self._force * scale
        if q in (*FIELDS, *STRAINS, *VELOCITIES, *STRESSES):
            return atom(Atom("exact", q)) * scale
        return constant(q) * scale

    @cached_property
    def leading(self) -> bool:
        """A prediction of a field's leading order: it names the saturated amplitude."""
        return "R_star" in self.names

    @cached_property
    def _force(self) -> Poly:
        """The force: the critical one, plus epsilon^2 Delta where the equation tells the two apart."""
        shift = constant("epsilon") ** 2 * constant("Delta")
        tells = self.names & {"force", "force_dim"} and self.names & {"force_c", "lambda"}
        return constant("force") + (shift if tells else 0)

    def scale(self, q: str) -> Poly:
        if not self.dimensional or q not in UNITS:
            return poly(1)
        length, stiffness, drag = UNITS[q]
        return constant("L") ** length * constant("k3") ** stiffness * constant("gamma2") ** drag

    def _simple(self, q: str) -> Poly | None:
        """Numbers and functions that are no vectors."""
        law = self.theory.d.law  # a rod has parameters of its own
        if q == "i":
            return I
        if q in CONSTANTS:
            return self.theory.named(q)
        if q in ("H", "P0", "P2"):
            return self.theory.shapes[q]
        if q in ("g1", "g2", "g3", "g4"):
            return self.theory.g[q]
        if q in SHAPES:
            return atom(Atom("shape", q))
        if q == "A":
            polar = self.names & {"R", "phase"}
            return constant("R") * exp(I * constant("phase")) if polar else atom(Atom("amplitude", "A"))
        if q == "any":
            known = (atom(Atom("exact", f"any_{n}")) * constant("epsilon") ** n for n in (0, *ORDERS))
            return sum(known, beyond({"any", "epsilon"}))
        return {
            "force": self._force,
            "force_c": constant("force"),
            "omega_c": constant("omega"),
            "omega": constant("omega_branch"),
            "tau": constant("t"),
            "T": constant("T"),
        }.get(q, constant(q) if q in (*law.parameters, *law.constants) else None)

    def _vector(self, q: str) -> tuple[Poly, ...] | Array | None:
        theory = self.theory
        x, y, cos, sin = (atom(Atom("exact", f)) for f in ("x", "y", "cos", "sin"))
        zero, one = poly(0), poly(1)
        length = self.scale("u")
        if q == "G":
            y_row, theta_row = theory.resonant
            return (zero, y_row * theory.weights[1].inverse(), theta_row * theory.weights[2].inverse())
        if q == "xi":
            if any(isinstance(n, Diff) for n in walk(self.equation.body)) or self.free:
                return tuple(atom(Atom("field", f, 1)) for f in FIELDS)
            return (zero, atom(Atom("shape", "Y")), atom(Atom("shape", "Theta")))
        if q in ("Psi", "Phi"):
            if "Phi" in self.names:
                return tuple(atom(Atom("shape", f"{q}{k}")) for k in range(3))
            return (zero, atom(Atom("shape", "Psi_Y")), atom(Atom("shape", "Psi_Theta")))
        if q == "Gamma":
            return tuple(tuple(w if i == j else zero for j in range(3)) for i, w in enumerate(theory.weights))
        if q == "L":
            return theory.operator
        if q == "weighted_L":
            return tuple(
                tuple(w * e for e in row) for w, row in zip(theory.weights, theory.operator, strict=True)
            )
        return {
            "r": (x * length, y * length),
            "e1": (cos, sin),
            "e2": (-sin, cos),
            "r_free": (constant("u") * length, zero),
            "e1_free": (one, zero),
            "e2_free": (zero, one),
        }.get(q)


def derivatives(node: Node) -> int:
    """How many derivatives stand on top of each other."""
    own = node.n if isinstance(node, (Diff, Prime)) else 0
    return own + max(map(derivatives, children(node)), default=0)


def beyond(quantities: set[str]) -> Poly:
    """What a power series of these quantities in epsilon holds beyond the orders of the theory."""
    return constant(f"{', '.join(sorted(quantities))} beyond order {ORDERS[-1]}")
