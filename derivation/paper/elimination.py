r"""Sums of integrals and end values as vectors, and their elimination: modulo a prime, or in the parameters.

A column is what stands beside the parameters in a term: an integral, end values, or both. Its entry is an
integer modulo a prime, the parameters having the values of one rod there, or a rational function of them.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import cache
from hashlib import sha256
from typing import Any

from sympy import QQ, QQ_I, symbols

from derivation.paper.algebra import ONE, Atom, Monomial, Poly, U, atom, poly

PRIME = 2**61 - 1

Vector = dict[Monomial, Any]
"""Coefficients of integrals and of end values; in elimination these columns, and relations, are numbers."""


def integral_in(column: Monomial) -> Atom | None:
    """The integral of a column, None in one of end values."""
    return next((a for a, _ in column if a.kind == "integral"), None)


def integrand(a: Atom) -> Monomial:
    """The product that an integral is of."""
    (inside,) = a.arg.terms
    found: Monomial = inside
    return found


def split(m: Monomial) -> tuple[Monomial, Monomial]:
    """Parameters, and what stands beside them."""
    parameters = frozenset((a, e) for a, e in m if a.kind == "constant" and a != U)
    return parameters, m - parameters


def vector(p: Poly, coefficient: Callable[[Poly], Any]) -> Vector:
    """p by what stands beside the parameters."""
    sums: dict[Monomial, dict[Monomial, Any]] = {}
    for m, c in p.terms.items():
        parameters, rest = split(m)
        sums.setdefault(rest, {})[parameters] = c
    found = {rest: coefficient(Poly(terms)) for rest, terms in sums.items()}
    return {rest: x for rest, x in found.items() if x}


def residue(p: Poly) -> int:
    """A function of the parameters at the one rod, whose numbers are made from their names."""
    total = 0
    for m, c in p.terms.items():
        value = int(c.x.numerator) * pow(int(c.x.denominator), -1, PRIME)
        for a, e in m:
            value = value * pow(_value_of(a), e, PRIME) % PRIME
        total += value
    return total % PRIME


@cache
def _value_of(a: Atom) -> int:
    return int.from_bytes(sha256(repr(a).encode()).digest()[:7])


class Echelon:
    """Vectors over a field, each with a leading column that no later one has.

    The entries are elements of the field or, with a modulus, integers modulo this prime. Columns are
    numbered by rank; below zero stand the numbers of the vectors that a combination is made of.

    Attributes:
        idle: vectors that hold no integral, with the numbers of those they are made of.
    """

    def __init__(self, vectors: list[Vector], modulus: int | None = None) -> None:
        self.modulus = modulus
        self.columns = sorted({c for v in vectors for c in v}, key=_rank)
        self.numbers = {c: k for k, c in enumerate(self.columns)}
        self.rows: dict[int, dict[int, Any]] = {}
        for k, v in enumerate(vectors):
            row = self._reduced({self.numbers[c]: x for c, x in v.items()} | {-1 - k: 1}, 0)
            if (lead := max(row)) >= 0:
                inverse = 1 / row[lead] if modulus is None else pow(row[lead], -1, modulus)
                self.rows[lead] = {n: self._in_field(x * inverse) for n, x in row.items()}
        self.integrals = next((k for c, k in self.numbers.items() if integral_in(c)), len(self.columns))
        self.idle = [self._parted(row) for k, row in self.rows.items() if k < self.integrals]

    def reduced(self, v: Vector, *, ends: bool) -> tuple[Vector, list[int]]:
        """v without leading columns, of end values only if told so, and the numbers of what it took."""
        others = {c: x for c, x in v.items() if c not in self.numbers}
        if any(map(integral_in, others)):
            return v, []
        known = {self.numbers[c]: x for c, x in v.items() if c in self.numbers}
        row = self._reduced(known, 0 if ends else self.integrals)
        rest, taken = self._parted(row)
        return rest | others, taken

    def _parted(self, row: dict[int, Any]) -> tuple[Vector, list[int]]:
        return {self.columns[k]: x for k, x in row.items() if k >= 0}, [-1 - k for k in row if k < 0]

    def _reduced(self, row: dict[int, Any], first: int) -> dict[int, Any]:
        while leads := [k for k in row if k >= first and k in self.rows]:
            times = row[lead := max(leads)]
            for k, x in self.rows[lead].items():
                value = self._in_field(row.get(k, 0) - times * x)
                if value:
                    row[k] = value
                else:
                    del row[k]
        return row

    def _in_field(self, x: Any) -> Any:
        return x if self.modulus is None else x % self.modulus


@cache
def _rank(column: Monomial) -> tuple[Any, ...]:
    """Integrals above end values; among them those with X0 and X2, high powers of u, many primes."""
    a = integral_in(column)
    inside = dict(integrand(a)) if a else {}
    forced = sum(e for b, e in inside.items() if b.name in ("X0", "X2"))
    primes = sum(b.u * e for b, e in inside.items())
    return a is not None, forced, inside.get(U, 0), primes, str(sorted(map(str, column)))


class Functions:
    """The field of rational functions in the parameters that occur."""

    def __init__(self, polynomials: list[Poly]) -> None:
        found = {a for p in polynomials for m in p.terms for a, _ in split(m)[0]}
        self.parameters = sorted(found, key=repr) or [U]  # a field needs one
        self.field = QQ.frac_field(*symbols(f"p:{len(self.parameters)}"))

    def of(self, p: Poly) -> Any:
        gens = dict(zip(self.parameters, self.field.gens, strict=True))
        total = self.field.zero
        for m, c in p.terms.items():
            term = self.field.convert(QQ(c.x.numerator, c.x.denominator))
            for a, e in m:
                term = term * gens[a] ** e
            total += term
        return total

    def polynomial(self, v: Vector) -> Poly:
        """A vector with entries in the field as a polynomial again."""
        total = poly(0)
        for rest, x in v.items():
            total += Poly({rest: QQ_I.one}) * self._poly(x.numer) * self._poly(x.denom).inverse()
        return total

    def _poly(self, q: Any) -> Poly:
        total = poly(0)
        for exponents, c in q.terms():
            term = Poly({ONE: QQ_I(c, 0)})
            for a, e in zip(self.parameters, exponents, strict=True):
                term = term * atom(a) ** e
            total += term
        return total
