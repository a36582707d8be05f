"""Numbers, vectors and matrices of the algebra: sums, products, derivatives, operators on functions."""

from __future__ import annotations

from collections.abc import Callable
from fractions import Fraction

from derivation.paper.algebra import Poly, poly
from derivation.paper.reasons import UnfitError

Array = tuple[tuple[Poly, ...], ...]
Value = Poly | Array


def alike(left: Value, right: Value) -> tuple[list[Poly], list[Poly]]:
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


def each(value: Value, f: Callable[[Poly], Poly]) -> Value:
    return f(value) if isinstance(value, Poly) else tuple(tuple(f(p) for p in row) for row in value)


def derived(value: Value, variable: str, times: int) -> Value:
    for _ in range(times):
        value = each(value, lambda p: p.derive(variable))
    return value


def add(left: Value, right: Value) -> Value:
    if left == poly(0):
        return right
    if isinstance(left, Poly) and isinstance(right, Poly):
        return left + right
    if isinstance(left, Poly) or isinstance(right, Poly) or _shape(left) != _shape(right):
        raise UnfitError("a sum of a number and a vector")
    return tuple(tuple(a + b for a, b in zip(r, s, strict=True)) for r, s in zip(left, right, strict=True))


def times(left: Value, right: Value) -> Value:
    """Products of numbers, matrices and vectors; d/du in the left factor acts on functions in the right."""
    if isinstance(left, Poly) and isinstance(right, Poly):
        return _acted(left, right)
    if isinstance(left, Poly):
        return each(right, lambda p: _acted(left, p))
    if isinstance(right, Poly):
        return each(left, lambda p: _acted(p, right))
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


def integer(p: Poly) -> int | None:
    """The integer that a polynomial is, None when it is none."""
    if not p:
        return 0
    ((m, c), *more) = p.terms.items()
    if more or m or c.y or Fraction(str(c.x)).denominator != 1:
        return None
    return int(c.x)


def column(value: Value) -> list[Poly]:
    if isinstance(value, Poly) or len(value) != 3 or len(value[0]) != 1:
        raise UnfitError("an inner product of something other than vectors of three")
    return [row[0] for row in value]


def diagonal_power(array: Array, n: int) -> Array:
    if any(p for i, row in enumerate(array) for j, p in enumerate(row) if i != j):
        raise UnfitError("a power of a matrix that is not diagonal")
    return tuple(tuple(p**n if i == j else p for j, p in enumerate(row)) for i, row in enumerate(array))
