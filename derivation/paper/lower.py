"""The meaning of a syntax tree: left side minus right side as an element of the exact algebra.

Each letter becomes what the derivation made of the quantity that the notation says it is. Nothing is looked
up by a label: the same tree means the same wherever it stands.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from itertools import product

from derivation.paper.algebra import (
    Atom,
    I,
    Poly,
    atom,
    constant,
    exp,
    poly,
    rational,
)
from derivation.paper.functions import modulus, root, turned
from derivation.paper.letters import COORDINATES, Letters, beyond
from derivation.paper.meanings import ORDERS, integral
from derivation.paper.reasons import UndecidedError, UnfitError
from derivation.paper.syntax import (
    Abs,
    Apply,
    At,
    Conj,
    Dagger,
    Diff,
    Dot,
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
from derivation.paper.values import (
    Value,
    add,
    alike,
    column,
    derived,
    diagonal_power,
    each,
    integer,
    times,
)

#: Powers, and the limits of sums, of at most so much are written out.
MOST = 12


@dataclass
class Lowering(Letters):
    """One equation on its way into the algebra."""

    def differences(self) -> Iterator[Poly]:
        """Left minus right, component by component, for every value of order letters and free indices."""
        body = self.equation.body
        if not isinstance(body, Relation):
            return
        letters = sorted({s.order for s in self._letters() if s.order.isalpha()} - self._bound())
        if len(letters) > 3:
            raise UndecidedError(f"{len(letters)} letters for orders: {', '.join(letters)}")
        for values in product(*([ORDERS] * len(letters) + [range(3)] * len(self.free))):
            self.indices = dict(zip((*letters, *self.free), values, strict=True))
            left, right = self.value(body.left), self.value(body.right)
            for a, b in zip(*alike(left, right), strict=True):
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
        return each(self.value(n.arg), lambda p: -p)

    def _sum(self, n: Sum) -> Value:
        """Terms; "+ c.c." adds the conjugate of all the others."""
        rest = [t for t in n.terms if t != Rest("cc")]
        values = [self.value(t) for t in rest]
        if len(rest) < len(n.terms):
            values = [each(v, lambda p: p + p.conjugate()) for v in values]
        total = next((v for v in values if v != poly(0)), poly(0))
        started = False
        for v in values:
            if v == poly(0):
                continue
            total = v if not started else add(total, v)
            started = True
        return total

    def _rest(self, n: Rest) -> Poly:
        if n.kind == "cc":
            raise UnfitError("c.c. that is not a term of a sum")
        self.left_out.add(n.kind)
        return poly(0)

    def _prod(self, n: Prod) -> Value:
        factors = list(n.factors)
        if any(isinstance(f, Sym) and self.quantity_of(f)[0] == "order" for f in factors):
            self._leave_out(factors)
            return poly(0)
        for k, f in enumerate(factors[:-1]):
            if isinstance(f, Sym) and self.quantity_of(f)[0] == "delta":  # delta F is one quantity
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
            result = times(self.value(f), result)
        return result

    def _summed(self, n: Prod) -> list[str]:
        found = [i for s in walk(n) if isinstance(s, Sym) for i in self.quantity_of(s)[1]]
        lone = [i for i in set(found) - set(self.free) if found.count(i) == 1]
        if lone:
            raise UnfitError(f"the index {lone[0]} stands once and is not on the left")
        return sorted({i for i in found if found.count(i) > 1 and i not in self.free})

    def _contraction(self, factors: list[Expr], summed: list[str]) -> Value:
        total: Value = poly(0)
        for values in product(range(3), repeat=len(summed)):
            self.indices |= dict(zip(summed, values, strict=True))
            total = add(total, self._multiplied(factors))
        return total

    def _leave_out(self, factors: list[Expr]) -> None:
        """O(x): terms of the degree of x in the detuning and more are dropped."""
        rest = [
            self.scalar(f) for f in factors if not (isinstance(f, Sym) and self.quantity_of(f)[0] == "order")
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
            return times(left, right)
        if len(left[0]) > 1:  # a matrix times a vector
            return times(left, right)
        if len(left) != len(right) or len(left[0]) != len(right[0]):
            raise UnfitError("a scalar product of vectors of different length")
        return sum((a[0] * b[0] for a, b in zip(left, right, strict=True)), poly(0))

    def _quot(self, n: Quot) -> Value:
        inverse = self.scalar(n.den).inverse()
        return each(self.value(n.num), lambda p: p * inverse)

    def _power(self, n: Power) -> Value:
        exponent = self.scalar(n.exponent)
        m = integer(exponent)
        if m is not None and abs(m) > MOST:
            raise UndecidedError(f"a power above {MOST}")
        if isinstance(n.base, Abs):
            inner = self.scalar(n.base.arg)
            if m is not None and m % 2 == 0:
                return (inner * inner.conjugate()) ** (m // 2)
        base = self.value(n.base)
        if m is None:
            if len(exponent.terms) == 1 and exponent * 2 == poly(1):
                return root(self.scalar(n.base))
            raise UndecidedError("a power that is not an integer")
        if not isinstance(base, Poly):
            return diagonal_power(base, m)
        return base**m

    def _prime(self, n: Prime) -> Value:
        if isinstance(n.arg, Apply):  # the slope there, not that of a number
            return self.value(replace(n.arg, fn=replace(n, arg=n.arg.fn)))
        return derived(self.value(n.arg), "u", n.n)

    def _conj(self, n: Conj) -> Value:
        return each(self.value(n.arg), Poly.conjugate)

    def _dagger(self, n: Dagger) -> Value:
        if isinstance(n.arg, Sym) and self.quantity_of(n.arg)[0] == "L":
            return self.theory.adjoint_operator
        value = self.value(n.arg)
        if isinstance(value, Poly):
            return value.conjugate()
        return tuple(tuple(value[j][i].conjugate() for j in range(len(value))) for i in range(len(value[0])))

    def _abs(self, n: Abs) -> Value:
        return modulus(self.scalar(n.arg))

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
            return root(value)
        up, down = turned(value), turned(-value)
        return (up + down) * rational(1, 2) if n.name == "cos" else (up - down) * (I * 2).inverse()

    def _diff(self, n: Diff) -> Value:
        variable, _ = self.quantity_of(n.var)
        scale = self.scale(variable or "").inverse() ** n.n
        if n.arg is None:
            if variable not in COORDINATES:
                raise UndecidedError("an operator d/d of something that is not a coordinate")
            return atom(Atom("operator", variable)) ** n.n * scale
        if variable in ("force", "force_c"):
            return self._by_force(n)
        if variable == "u" and isinstance(n.arg, Apply):  # the slope there, not that of a number
            return self.value(replace(n.arg, fn=replace(n, arg=n.arg.fn)))
        value = self.value(n.arg)
        if variable not in (*COORDINATES, "R"):
            raise UndecidedError("a derivative along something that is not a coordinate")
        if variable == "R" and any(_holds_amplitude(p) for p in alike(value, value)[0]):
            raise UndecidedError("a derivative in R of a field")
        for _ in range(n.n):
            if variable in ("R", "t", "T"):  # dR/dT is a function of R
                value = each(value, lambda p: self.theory.canonical(p, keep=frozenset({"T"})))
            value = derived(value, variable, 1)
        return each(value, lambda p: p * scale)

    def _by_force(self, n: Diff) -> Poly:
        if not (isinstance(n.arg, Sym) and self.quantity_of(n.arg)[0] == "lambda" and n.n == 1):
            raise UndecidedError("a derivative in the force of something other than lambda")
        return constant("lambda_F")

    def _int(self, n: Int) -> Value:
        if self.quantity_of(n.var)[0] != "u":
            raise UndecidedError("an integral along something other than u")
        lower, upper = self.end(n.lower), self.end(n.upper)
        return integral(self.scalar(n.arg)) * (upper - lower) * self.scale("u")

    def _series(self, n: Series) -> Value:
        """A finite sum, or a series in epsilon: its known orders, and what is beyond them."""
        letter, first = n.index.base, integer(self.scalar(n.lower))
        endless = n.upper == Num(None)
        last = max(ORDERS) if endless else integer(self.scalar(n.upper))
        if first is None or last is None or first < -MOST or last > MOST:
            raise UndecidedError("a sum whose limits are not small integers")
        factors = n.arg.factors if isinstance(n.arg, Prod) else (n.arg,)
        if endless and not any(self._counts(f, n.index) for f in factors):
            if any(isinstance(s, Sym) and s.order == letter for s in walk(n.arg)):
                raise UnfitError("a sum over orders without powers of epsilon")
            raise UndecidedError("an infinite sum that is no series in epsilon")
        total: Value = poly(0)
        for k in range(first, last + 1):
            self.indices[letter] = k
            total = add(total, self.value(n.arg))
        if endless and isinstance(total, Poly):
            names = {q for s in walk(n.arg) if isinstance(s, Sym) and (q := self.quantity_of(s)[0])}
            total += beyond(names - {*COORDINATES})
        return total

    def _counts(self, n: Node, index: Sym) -> bool:
        """epsilon to the power of the index."""
        if not (isinstance(n, Power) and isinstance(n.base, Sym) and n.exponent == index):
            return False
        return self.quantity_of(n.base)[0] == "epsilon"

    def _apply(self, n: Apply) -> Value:
        head = n.fn
        while isinstance(head, (Prime, Diff, Conj, Dagger, Abs, Power)):
            inner = head.base if isinstance(head, Power) else head.arg
            assert inner is not None  # a derivative has its operand where it is applied
            head = inner
        if isinstance(head, Sym) and self.quantity_of(head)[0] == "lambda":
            return self._eigenvalue(n.args)
        value = self.value(n.fn)
        letters = self.notation.functions.get(head.name, ()) if isinstance(head, Sym) else ()
        along = any(self.notation.quantity(letter) == "u" for letter in letters)
        for k, arg in enumerate(n.args):
            end = self._argument(arg, along=along and k == 0)
            if end is not None:
                value = each(value, lambda p, e=end: p.at(e))  # type: ignore[misc]
        return value

    def _argument(self, arg: Node, *, along: bool) -> int | None:
        """The end of the rod that an argument names, None for a coordinate; u is the first argument."""
        if isinstance(arg, Sym) and self.quantity_of(arg)[0] in ("u", "t", "tau", "T", "phase"):
            return None
        if isinstance(arg, Relation) and self._is(arg.left, "u"):
            return self.end(arg.right)
        if not along:
            raise UndecidedError("a value at a time or at a number that is no place of the rod")
        return self.end(arg)

    def _is(self, node: Node, *quantities: str) -> bool:
        return isinstance(node, Sym) and self.quantity_of(node)[0] in quantities

    def _eigenvalue(self, args: tuple[Node, ...]) -> Poly:
        """lambda about the threshold as a Taylor polynomial; lambda(F_c) = i omega_c."""
        shift = self.scalar(args[0]) - constant("force")
        total, power = I * constant("omega"), poly(1)
        for k, name in enumerate(("lambda_F", "lambda_FF", "lambda_FFF"), 1):
            power = power * shift * rational(1, k)
            total += constant(name) * power
        return total

    def _at(self, n: At) -> Value:
        """A value at an end of the rod, at the threshold, or at an R."""
        value = self.value(n.arg)
        letter, new = (n.place.left, n.place.right) if isinstance(n.place, Relation) else (None, n.place)
        if letter is not None and self._is(letter, "u"):
            end = self.end(new)
            return each(value, lambda p: p.at(end))
        if self._is(new, "force_c") and (letter is None or self._is(letter, "force", "force_dim")):
            delta = Atom("constant", "Delta")
            return each(value, lambda p: p.map(lambda a: poly(0) if a == delta else None))
        if letter is None or not self._is(letter, "R"):
            raise UndecidedError("a value at a place that is neither an end, nor the threshold, nor an R")
        radius, at = Atom("constant", "R"), self.scalar(new)
        return each(value, lambda p: self.theory.canonical(p).map(lambda a: at if a == radius else None))

    def _matrix(self, n: Matrix) -> Value:
        array = tuple(tuple(self.scalar(e) for e in row) for row in n.rows)
        if not self.free:
            return array
        row, *column = (self.indices[i] for i in self.free)
        if len(array) != 3 or len(array[0]) != (3 if column else 1):
            raise UnfitError("a matrix that does not fit the indices on the left")
        return array[row][column[0] if column else 0]

    def _tuple(self, n: Tuple) -> Value:
        if n.weight is None:
            return tuple((self.scalar(item),) for item in n.items)
        if not (isinstance(n.weight, Sym) and self.quantity_of(n.weight)[0] == "Gamma"):
            raise UndecidedError("an inner product with another weight")
        left, right = (column(self.value(item)) for item in n.items)
        return integral(
            sum(
                (a.conjugate() * w * b for a, w, b in zip(left, self.theory.weights, right, strict=True)),
                poly(0),
            )
        )


def _holds_amplitude(p: Poly) -> bool:
    """Whether a letter stands for something in which the amplitude is hidden."""
    return any(a.kind in ("field", "exact", "amplitude") for a in p.atoms)
