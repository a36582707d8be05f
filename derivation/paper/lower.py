"""The meaning of a syntax tree: left side minus right side as an element of the exact algebra.

Each letter becomes what the derivation made of the quantity that the notation says it is. Nothing is looked
up by a label: the same tree means the same wherever it stands.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from fractions import Fraction
from functools import cached_property
from itertools import product

from derivation.paper.algebra import Atom, I, Poly, atom, constant, exp, poly, rational
from derivation.paper.notation import Notation
from derivation.paper.syntax import (
    Abs,
    Apply,
    At,
    Conj,
    Dagger,
    Diff,
    Dot,
    Equation,
    Expr,
    Func,
    Int,
    Matrix,
    Neg,
    Node,
    Num,
    Power,
    Prime,
    Prod,
    Quot,
    Relation,
    Rest,
    Series,
    Sum,
    Sym,
    Tuple,
    walk,
)  # fmt: skip
from derivation.paper.theory import FIELDS, LOADS, ORDERS, STRAINS, STRESSES, VELOCITIES, Theory, integral

Array = tuple[tuple[Poly, ...], ...]
Value = Poly | Array

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


class UndecidedError(Exception):
    """An expression has no meaning here; the message is the reason that the ledger gives."""


class UnfitError(Exception):
    """The letters are known, but they do not go together: a vector set equal to a number."""


@dataclass
class Lowering:
    """One equation on its way into the algebra.

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
        return {(q, s.order) for s in self._letters() if (q := self._quantity(s)[0])}

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
            and self._quantity(body.left)[0] in SCALED
        ):
            found = (self._quantity(s)[0] for s in walk(body.right) if isinstance(s, Sym))
            rest = {q for q in found if q}
        measured = {q for q in rest if q.endswith("_dim") or (q in UNITS and q not in ("u", "t"))}
        return bool(measured) and not set(SCALED) & rest

    @cached_property
    def place(self) -> int | None:
        where = self.equation.place or (self.equation.said if self._is_condition else None)
        return None if where is None else self._end(where.right)

    @property
    def _is_condition(self) -> bool:
        """A place that the text alone gives counts where no letter is evaluated in the equation itself."""
        return not isinstance(self.equation.body, Tuple)

    @cached_property
    def free(self) -> tuple[str, ...]:
        """Index letters of the left side."""
        body = self.equation.body
        found: list[str] = []
        if isinstance(body, Relation):
            for s in walk(body.left):
                if isinstance(s, Sym):
                    found += [i for i in self._quantity(s)[1] if i not in found]
        return tuple(found)

    def _letters(self) -> Iterator[Sym]:
        return (s for s in walk(self.equation.body) if isinstance(s, Sym))

    def _quantity(self, s: Sym) -> tuple[str | None, tuple[str, ...]]:
        """What a letter stands for, and its index letters."""
        q = self.notation.quantity(s.name)
        if q is not None:
            return q, ()
        split = tuple(f"\\{part}" for part in s.sub.split("\\")[1:])
        q = self.notation.quantity(s.base)
        if q in ("xi", "L") and split and set(split) <= {"\\alpha", "\\beta"}:
            return q, split
        return None, ()

    # The difference --------------------------------------------------------------------------------------

    def differences(self) -> Iterator[Poly]:
        """Left minus right, component by component, for every value of order letters and free indices."""
        body = self.equation.body
        if not isinstance(body, Relation):
            return
        letters = sorted({s.order for s in self._letters() if s.order.isalpha()} - self._bound())
        for values in product(*([ORDERS] * len(letters) + [range(3)] * len(self.free))):
            self.indices = dict(zip((*letters, *self.free), values, strict=True))
            left, right = self.value(body.left), self.value(body.right)
            for a, b in zip(*_alike(left, right), strict=True):
                yield a - b if self.place is None else (a - b).at(self.place)

    def _bound(self) -> set[str]:
        return {n.index.base for n in walk(self.equation.body) if isinstance(n, Series)}

    def value(self, node: Node) -> Value:
        """The value of a node.

        Raises:
            UndecidedError: for what has no meaning here.
        """
        method: Callable[[Node], Value] | None = getattr(self, f"_{type(node).__name__.lower()}", None)
        if method is None:
            raise UndecidedError(f"no meaning for {type(node).__name__} here")
        return method(node)

    def scalar(self, node: Node) -> Poly:
        value = self.value(node)
        if not isinstance(value, Poly):
            raise UnfitError("a vector where a number was expected")
        return value

    def _num(self, n: Num) -> Poly:
        if n.value is None:
            raise UndecidedError("infinity outside a limit")
        return rational(n.value.numerator, n.value.denominator)

    def _neg(self, n: Neg) -> Value:
        return _each(self.value(n.arg), lambda p: -p)

    def _sum(self, n: Sum) -> Value:
        """Terms; "+ c.c." adds the conjugate of all the others."""
        rest = [t for t in n.terms if t != Rest("cc")]
        values = [self.value(t) for t in rest]
        if len(rest) < len(n.terms):
            values = [_each(v, lambda p: p + p.conjugate()) for v in values]
        total = next((v for v in values if v != poly(0)), poly(0))
        started = False
        for v in values:
            if v == poly(0):
                continue
            total = v if not started else _add(total, v)
            started = True
        return total

    def _rest(self, n: Rest) -> Poly:
        if n.kind == "cc":
            raise UnfitError("c.c. that is not a term of a sum")
        self.left_out.add(n.kind)
        return poly(0)

    def _prod(self, n: Prod) -> Value:
        factors = list(n.factors)
        if any(isinstance(f, Sym) and self._quantity(f)[0] == "order" for f in factors):
            self._leave_out(factors)
            return poly(0)
        for k, f in enumerate(factors[:-1]):
            if isinstance(f, Sym) and self._quantity(f)[0] == "delta":  # delta F is one quantity
                factors[k : k + 2] = [Prod((f, factors[k + 1]))]
                break
        if len(factors) == 1:
            return constant("step")
        summed = self._summed(n)
        if summed:
            return self._contraction(factors, summed)
        return self._multiplied(factors)

    def _multiplied(self, factors: list[Expr]) -> Value:
        """From the right, so that an operator acts on what stands after it."""
        result = self.value(factors[-1])
        for f in reversed(factors[:-1]):
            result = _times(self.value(f), result)
        return result

    def _summed(self, n: Prod) -> list[str]:
        found = [i for s in walk(n) if isinstance(s, Sym) for i in self._quantity(s)[1]]
        lone = [i for i in set(found) - set(self.free) if found.count(i) == 1]
        if lone:
            raise UnfitError(f"the index {lone[0]} stands once and is not on the left")
        return sorted({i for i in found if found.count(i) > 1 and i not in self.free})

    def _contraction(self, factors: list[Expr], summed: list[str]) -> Value:
        total: Value = poly(0)
        for values in product(range(3), repeat=len(summed)):
            self.indices |= dict(zip(summed, values, strict=True))
            total = _add(total, self._multiplied(factors))
        return total

    def _leave_out(self, factors: list[Expr]) -> None:
        """O(x): terms of the degree of x in the detuning and more are dropped."""
        rest = [
            self.scalar(f) for f in factors if not (isinstance(f, Sym) and self._quantity(f)[0] == "order")
        ]
        total = poly(1)
        for p in rest:
            total = total * p
        degree = total.degree(Atom("constant", "Delta"))
        if len(total.terms) != 1 or not degree:
            raise UnfitError("a remainder that is not a power of the distance from the threshold")
        self.left_out.add(f"from {degree}")

    def _dot(self, n: Dot) -> Value:
        left, right = self.value(n.left), self.value(n.right)
        if isinstance(left, Poly) or isinstance(right, Poly):
            return _times(left, right)
        return sum((a[0] * b[0] for a, b in zip(left, right, strict=True)), poly(0))

    def _quot(self, n: Quot) -> Value:
        inverse = self.scalar(n.den).inverse()
        return _each(self.value(n.num), lambda p: p * inverse)

    def _power(self, n: Power) -> Value:
        exponent = self.scalar(n.exponent)
        m = _integer(exponent)
        if isinstance(n.base, Abs):
            inner = self.scalar(n.base.arg)
            if m is not None and m % 2 == 0:
                return (inner * inner.conjugate()) ** (m // 2)
        base = self.value(n.base)
        if m is None:
            if len(exponent.terms) == 1 and exponent * 2 == poly(1):
                return atom(Atom("sqrt", arg=self.scalar(n.base)))
            raise UndecidedError("a power that is not an integer")
        if not isinstance(base, Poly):
            return _diagonal_power(base, m)
        if abs(m) > 12:
            raise UndecidedError("a power above 12")
        return base**m

    def _prime(self, n: Prime) -> Value:
        return _derived(self.value(n.arg), "u", n.n)

    def _conj(self, n: Conj) -> Value:
        return _each(self.value(n.arg), Poly.conjugate)

    def _dagger(self, n: Dagger) -> Value:
        if isinstance(n.arg, Sym) and self._quantity(n.arg)[0] == "L":
            return self.theory.adjoint_operator
        value = self.value(n.arg)
        if isinstance(value, Poly):
            return value.conjugate()
        return tuple(tuple(value[j][i].conjugate() for j in range(len(value))) for i in range(len(value[0])))

    def _abs(self, n: Abs) -> Value:
        inner = self.scalar(n.arg)
        return atom(Atom("sqrt", arg=inner * inner.conjugate()))

    def _func(self, n: Func) -> Value:
        if n.name == "diag":
            entries = n.arg.items if isinstance(n.arg, Tuple) else (n.arg,)
            return tuple(
                tuple(self.scalar(e) if i == j else poly(0) for j in range(len(entries)))
                for i, e in enumerate(entries)
            )
        value = self.scalar(n.arg)
        if n.name == "Re":
            return (value + value.conjugate()) * rational(1, 2)
        if n.name == "Im":
            return (value - value.conjugate()) * (I * 2).inverse()
        if n.name == "exp":
            return exp(value)
        if n.name == "sqrt":
            return atom(Atom("sqrt", arg=value))
        if value == atom(Atom("exact", "theta")):
            return atom(Atom("exact", n.name))
        up, down = exp(I * value), exp(-I * value)
        return (up + down) * rational(1, 2) if n.name == "cos" else (up - down) * (I * 2).inverse()

    def _diff(self, n: Diff) -> Value:
        variable, _ = self._quantity(n.var)
        scale = self._scale(variable or "").inverse() ** n.n
        if n.arg is None:
            if variable not in COORDINATES:
                raise UndecidedError("an operator d/d of something that is not a coordinate")
            return atom(Atom("operator", variable)) ** n.n * scale
        if variable in ("force", "force_c"):
            return self._by_force(n)
        value = self.value(n.arg)
        if variable == "R":
            return _derived(value, "R", n.n)
        if variable == "t" and not self._exact:
            variable = "tau"
        if variable not in COORDINATES:
            raise UndecidedError("a derivative along something that is not a coordinate")
        return _each(_derived(value, variable, n.n), lambda p: p * scale)

    @cached_property
    def _exact(self) -> bool:
        return not any(order for _, order in self.quantities) and not self.names & {"xi", "A", "Y"}

    def _by_force(self, n: Diff) -> Poly:
        if not (isinstance(n.arg, Sym) and self._quantity(n.arg)[0] == "lambda" and n.n == 1):
            raise UndecidedError("a derivative in the force of something other than lambda")
        return constant("lambda_F")

    def _int(self, n: Int) -> Value:
        if self._quantity(n.var)[0] != "u":
            raise UndecidedError("an integral along something other than u")
        lower, upper = self._end(n.lower), self._end(n.upper)
        return integral(self.scalar(n.arg)) * (upper - lower) * self._scale("u")

    def _series(self, n: Series) -> Value:
        letter, first = n.index.base, _integer(self.scalar(n.lower))
        if first is None:
            raise UndecidedError("a sum that does not begin at a number")
        total: Value = poly(0)
        for k in range(first, max(ORDERS) + 1):
            self.indices[letter] = k
            total = _add(total, self.value(n.arg))
        return total

    def _apply(self, n: Apply) -> Value:
        head = n.fn
        while isinstance(head, (Prime, Conj, Dagger)):
            head = head.arg
        quantity = self._quantity(head)[0] if isinstance(head, Sym) else None
        if quantity == "lambda":
            return self._eigenvalue(n.args)
        value = self.value(n.fn)
        for arg in n.args:
            end = self._argument(arg)
            if end is not None:
                value = _each(value, lambda p, e=end: p.at(e))  # type: ignore[misc]
        return value

    def _argument(self, arg: Node) -> int | None:
        """The end of the rod that an argument names; None for a coordinate."""
        if isinstance(arg, Relation):
            return self._end(arg.right)
        if isinstance(arg, Sym) and self._quantity(arg)[0] in ("u", "t", "tau", "T", "phase"):
            return None
        return self._end(arg)

    def _end(self, node: Node) -> int:
        if isinstance(node, Sym) and self._quantity(node)[0] == "length":
            return 1
        if isinstance(node, Num) and node.value in (0, 1):
            return int(node.value)
        raise UndecidedError("a place that is neither end of the rod")

    def _eigenvalue(self, args: tuple[Node, ...]) -> Poly:
        """lambda about the threshold as a Taylor polynomial; lambda(F_c) = i omega_c."""
        shift = self.scalar(args[0]) - constant("force")
        total, power = I * constant("omega"), poly(1)
        for k, name in enumerate(("lambda_F", "lambda_FF", "lambda_FFF"), 1):
            power = power * shift * rational(1, k)
            total += constant(name) * power
        return total

    def _at(self, n: At) -> Value:
        value = self.value(n.arg)
        if isinstance(n.place, Relation):
            old, new = self.scalar(n.place.left), self.scalar(n.place.right)
            (m,) = old.terms
            ((variable, _),) = m
            return _each(value, lambda p: p.map(lambda a: new if a == variable else None))
        if isinstance(n.place, Sym) and self._quantity(n.place)[0] == "force_c":
            return value
        raise UndecidedError("a value at a place that is not the threshold")

    def _matrix(self, n: Matrix) -> Value:
        array = tuple(tuple(self.scalar(e) for e in row) for row in n.rows)
        if self.free:
            return array[self.indices[self.free[0]]][self.indices[self.free[-1]]]
        return array

    def _tuple(self, n: Tuple) -> Value:
        if n.weight is None:
            return tuple((self.scalar(item),) for item in n.items)
        if not (isinstance(n.weight, Sym) and self._quantity(n.weight)[0] == "Gamma"):
            raise UndecidedError("an inner product with another weight")
        left, right = (_column(self.value(item)) for item in n.items)
        return integral(
            sum(
                (a.conjugate() * w * b for a, w, b in zip(left, self.theory.weights, right, strict=True)),
                poly(0),
            )
        )

    # Letters ---------------------------------------------------------------------------------------------

    def _sym(self, s: Sym) -> Value:
        q, index = self._quantity(s)
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
        hatted = s.order.isdigit()  # the general order n speaks of the variables as they are
        hats = ("x", "y_hat", "theta_hat") if n == 3 and hatted else FIELDS
        components = {"xi": hats, "forcing": ("f1", "f2", "f3")}.get(q, (q,))
        if q == "any":
            return constant(f"any_{n}")
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
        scale = self._scale(q)
        if q in ("k3", "gamma2", "length"):
            return scale if q != "length" else self._scale("u")
        if q == "u":
            return constant("u") * scale
        if q == "t":
            return constant("t") * scale
        if q in FIELDS and self._leading:
            return constant("epsilon") * atom(Atom("field", q, 1))
        if q in (*STRAINS, *VELOCITIES) and self.names & {"r", "e1", "e2"}:
            return self.theory.kinematics(q) * scale
        if q in LOADS:
            return -self.theory.drag[LOADS.index(q)] * scale
        if q == "energy":
            return integral(self.theory.energy) * scale
        if q == "force":
            return self._force * scale
        if q in (*FIELDS, *STRAINS, *VELOCITIES, *STRESSES):
            return atom(Atom("exact", q)) * scale
        return constant(q) * scale

    @cached_property
    def _leading(self) -> bool:
        """A prediction of a field's leading order: it names the saturated amplitude."""
        return "R_star" in self.names

    @cached_property
    def _force(self) -> Poly:
        """The force: the critical one, plus epsilon^2 Delta where the equation tells the two apart."""
        shift = constant("epsilon") ** 2 * constant("Delta")
        tells = self.names & {"force", "force_dim"} and self.names & {"force_c", "lambda"}
        return constant("force") + (shift if tells else 0)

    def _scale(self, q: str) -> Poly:
        if not self.dimensional or q not in UNITS:
            return poly(1)
        length, stiffness, drag = UNITS[q]
        return constant("L") ** length * constant("k3") ** stiffness * constant("gamma2") ** drag

    def _simple(self, q: str) -> Poly | None:
        """Numbers and functions that are no vectors."""
        if q == "i":
            return I
        if q in CONSTANTS:
            return constant(q)
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
            return sum((constant(f"any_{n}") * constant("epsilon") ** n for n in (0, *ORDERS)), poly(0))
        return {
            "force": self._force,
            "force_c": constant("force"),
            "omega_c": constant("omega"),
            "omega": constant("omega_branch"),
            "tau": constant("t"),
            "T": constant("epsilon") ** 2 * constant("t"),
        }.get(q)

    def _vector(self, q: str) -> tuple[Poly, ...] | Array | None:
        theory = self.theory
        x, y, cos, sin = (atom(Atom("exact", f)) for f in ("x", "y", "cos", "sin"))
        zero, one = poly(0), poly(1)
        length = self._scale("u")
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


def _alike(left: Value, right: Value) -> tuple[list[Poly], list[Poly]]:
    """Two values as lists of components; a zero stands for a zero vector."""
    if isinstance(left, Poly) and isinstance(right, Poly):
        return [left], [right]
    a, b = ([p for row in v for p in row] if not isinstance(v, Poly) else None for v in (left, right))
    if a is None or b is None:
        lone = left if a is None else right
        if lone != poly(0):
            raise UnfitError("a vector set equal to a number")
        return a or [poly(0)] * len(b or []), b or [poly(0)] * len(a or [])
    if len(a) != len(b):
        raise UnfitError("vectors of different length")
    return a, b


def _shape(array: Array) -> tuple[int, int]:
    return len(array), len(array[0])


def _each(value: Value, f: Callable[[Poly], Poly]) -> Value:
    return f(value) if isinstance(value, Poly) else tuple(tuple(f(p) for p in row) for row in value)


def _derived(value: Value, variable: str, times: int) -> Value:
    for _ in range(times):
        value = _each(value, lambda p: p.derive(variable))
    return value


def _add(left: Value, right: Value) -> Value:
    if left == poly(0):
        return right
    if isinstance(left, Poly) and isinstance(right, Poly):
        return left + right
    if isinstance(left, Poly) or isinstance(right, Poly) or _shape(left) != _shape(right):
        raise UnfitError("a sum of a number and a vector")
    return tuple(tuple(a + b for a, b in zip(r, s, strict=True)) for r, s in zip(left, right, strict=True))


def _times(left: Value, right: Value) -> Value:
    """Products of numbers, matrices and vectors; d/du in the left factor acts on functions in the right."""
    if isinstance(left, Poly) and isinstance(right, Poly):
        return _acted(left, right)
    if isinstance(left, Poly):
        return _each(right, lambda p: _acted(left, p))
    if isinstance(right, Poly):
        return _each(left, lambda p: _acted(p, right))
    if len(left[0]) != len(right):
        raise UnfitError("a product of arrays that do not fit")
    rows = tuple(
        tuple(
            sum((_acted(row[k], right[k][j]) for k in range(len(right))), poly(0))
            for j in range(len(right[0]))
        )
        for row in left
    )
    return rows[0][0] if len(rows) == 1 and len(rows[0]) == 1 else rows


def _acted(left: Poly, right: Poly) -> Poly:
    if not any(a.kind == "operator" for a in left.atoms) or any(a.kind == "operator" for a in right.atoms):
        return left * right
    total = poly(0)
    for m, c in left.terms.items():
        value = right
        rest = []
        for a, e in m:
            if a.kind == "operator":
                for _ in range(e):
                    value = value.derive(a.name)
            else:
                rest.append((a, e))
        total += Poly({frozenset(rest): c}) * value
    return total


def _integer(p: Poly) -> int | None:
    """The integer that a polynomial is, None when it is none."""
    if not p:
        return 0
    ((m, c), *more) = p.terms.items()
    if more or m or c.y or Fraction(str(c.x)).denominator != 1:
        return None
    return int(c.x)


def _column(value: Value) -> list[Poly]:
    if isinstance(value, Poly) or len(value) != 3 or len(value[0]) != 1:
        raise UnfitError("an inner product of something other than vectors of three")
    return [row[0] for row in value]


def _diagonal_power(array: Array, n: int) -> Array:
    if any(p for i, row in enumerate(array) for j, p in enumerate(row) if i != j):
        raise UnfitError("a power of a matrix that is not diagonal")
    return tuple(tuple(p**n if i == j else p for j, p in enumerate(row)) for i, row in enumerate(array))
