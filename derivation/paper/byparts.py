r"""Integrals over the rod, equal up to integration by parts.

Every shape obeys a linear equation of second order in u (those of X0 and X2 are forced by products of
modes). So among integrals over products of shapes and powers of u, and products of end values,

    int_0^1 q' du - q(1) + q(0) = 0,    q' reduced by the equations, q(1) and q(0) by the conditions there,

are the relations that are used, one for each product q. They are linear, their coefficients rational in the
rod's parameters, and d/du leaves how often each mode occurs: the q that matter are finitely many. A sum of
integrals and end values that is a combination of relations vanishes; that there are no others is not proved,
but a sum of which they leave something is said to differ. Which ones it takes is seen by
Gaussian elimination at one rod, modulo a prime. With these few it is reduced over the field of rational
functions, and what is left there is what counts.
"""

from __future__ import annotations

from collections.abc import Iterator
from itertools import combinations_with_replacement, product
from typing import NamedTuple

from sympy import QQ_I

from derivation.paper.algebra import Atom, I, Monomial, Poly, U, atom, constant, poly
from derivation.paper.elimination import (
    PRIME,
    Echelon,
    Functions,
    Vector,
    integral_in,
    integrand,
    residue,
    split,
    vector,
)
from derivation.paper.meanings import integral
from derivation.paper.reasons import UndecidedError
from derivation.paper.theory import Theory

#: How often a shape counts as the mode and as the conjugate mode.
MODES = {"Y": (1, 0), "Theta": (1, 0), "X0": (1, 1), "X2": (2, 0)}
ADJOINT = ("Psi_Y", "Psi_Theta")
#: Shapes that the reflection u -> -u of the equations turns; d/du turns the others.
ODD = ("Theta", "X0", "X2", "Psi_Theta")
#: Integrands of at most so many modes, X0 and X2 counted as two, are reduced: those of alpha have as many.
FACTORS = 4
#: Powers of u beyond those in the integrand: X0' and products such as that of Psi and Y hold constants.
MORE_POWERS = 2
#: Relations that a proof may take, and those with which a difference is brought to the ends to be shown.
MOST, SHOWN = 40, 4
#: lambda = i omega: in it everything is real, so real and imaginary parts vanish separately.
LAMBDA = Atom("constant", "lambda at the threshold")


class Family(NamedTuple):
    """Integrands that d/du mixes: what occurs how often, parity under reflection, highest power of u."""

    content: tuple[int, ...]
    parity: int
    power: int


def by_parts(theory: Theory, p: Poly) -> Poly:
    """What is left of a sum of integrals and end values; zero only if it vanishes.

    Free of integrals if few integrations by parts bring them all to the ends, else as it was.

    Raises:
        UndecidedError: if it vanishes at one rod, but by more relations than can be handled for all rods, or
            if the straight rod is not uniform: its equations have no parity under reflection.
    """
    columns = {c for m in p.terms if integral_in(c := split(m)[1])}
    if not columns or not all(is_known(c) for c in columns):
        return p
    if theory.profiles:
        raise UndecidedError("integrals along a straight rod that is not uniform are compared as printed")
    left = poly(0)
    for unit, part in zip((poly(1), I), _parts(p), strict=True):
        rest = _reduced(theory, part)
        if rest is None:
            return p
        left += unit * rest
    return left.map(lambda a: I * constant("omega") if a == LAMBDA else None)


def _reduced(theory: Theory, p: Poly) -> Poly | None:
    """What is left of a p with real coefficients; None if integrals are."""
    rest, used, idle = _at_one_rod(theory, p)
    if any(map(integral_in, rest)):
        return None
    left, more = Echelon([v for v, _ in idle], PRIME).reduced(rest, ends=True)
    if not left:
        used += [idle[k][1] for k in more]
    count = sum(len(numbers) for _, _, numbers in used)
    if left and count > SHOWN:
        return None
    if count > MOST:
        raise UndecidedError(f"the integrals agree at one rod, by {count} integrations by parts")
    taken = [Poly({factor: QQ_I.one}) * rows[k] for factor, rows, numbers in used for k in numbers]
    functions = Functions([p, *taken])
    exact = Echelon([vector(q, functions.of) for q in taken])
    found, _ = exact.reduced(vector(p, functions.of), ends=True)
    return None if any(map(integral_in, found)) else functions.polynomial(found)


Used = tuple[Monomial, list[Poly], list[int]]
"""A product of end values, relations to be multiplied by it, and the numbers of those that are used."""


def _at_one_rod(theory: Theory, p: Poly) -> tuple[Vector, list[Used], list[tuple[Vector, Used]]]:
    """p there without the integrals that go, the relations used, and what holds among end values alone."""
    groups: dict[tuple[Monomial, tuple[int, ...], int], Vector] = {}
    total: Vector = {}
    for column, x in vector(p, residue).items():
        a = integral_in(column)
        if a is None:
            total[column] = x
        else:
            factor, family = column - {(a, 1)}, _family(a)
            groups.setdefault((factor, *family[:2]), {})[frozenset([(a, 1)])] = x
    used: list[Used] = []
    idle: list[tuple[Vector, Used]] = []
    for (factor, content, parity), v in groups.items():
        highest = max(_family(a).power for c in v if (a := integral_in(c)))
        for power in range(highest, highest + MORE_POWERS + 1):
            relations, echelon = _relations(theory, Family(content, parity, power))
            rest, numbers = echelon.reduced(v, ends=False)
            if not any(map(integral_in, rest)):
                break
        used.append((factor, relations, numbers))
        idle += [(_weighted(row, factor), (factor, relations, taken)) for row, taken in echelon.idle]
        for column, x in _weighted(rest, factor).items():
            total[column] = (total.get(column, 0) + x) % PRIME
    return {c: x for c, x in total.items() if x}, used, idle


def _weighted(v: Vector, factor: Monomial) -> Vector:
    weight = Poly({factor: QQ_I.one})
    return {next(iter((weight * Poly({c: QQ_I.one})).terms)): x for c, x in v.items()}


def _relations(theory: Theory, family: Family) -> tuple[list[Poly], Echelon]:
    """The relations between integrals of a family, and these reduced at one rod."""
    made = theory.__dict__.setdefault("relations", {})
    if family not in made:
        relations = [
            _relation(theory, q * atom(U) ** k)
            for k in range(family.power + 1)
            for q in _products(family.content, (family.parity + k + 1) % 2)
        ]
        made[family] = relations, Echelon([vector(r, residue) for r in relations], PRIME)
    found: tuple[list[Poly], Echelon] = made[family]
    return found


def _relation(theory: Theory, q: Poly) -> Poly:
    """int q' - q(1) + q(0)."""
    slope, ends = (theory.canonical(theory.by_equations(p)) for p in (q.derive("u"), q.at(1) - q.at(0)))
    real, imaginary = _parts(integral(slope) - ends)
    if imaginary:
        raise UndecidedError("the rod's equations are not real in lambda")
    return real


def _products(content: tuple[int, ...], parity: int) -> Iterator[Poly]:
    """All products of shapes and their first derivatives of this content and parity, few primes first."""
    plain, starred, psi, psi_bar = content
    letters = [Atom("shape", s, u=k, bar=bar) for s in MODES for k in (0, 1) for bar in (False, True)]
    modes = [m for n in range(plain + starred + 1) for m in combinations_with_replacement(letters, n)]
    adjoint = [
        combinations_with_replacement([Atom("shape", s, u=k, bar=bar) for s in ADJOINT for k in (0, 1)], n)
        for bar, n in ((False, psi), (True, psi_bar))
    ]
    fitting = [m for m in modes if _content_of(m)[:2] == (plain, starred)]
    found = [f for a, b, c in product(fitting, *adjoint) if _parity(f := (*a, *b, *c)) == parity]
    for factors in sorted(found, key=lambda f: sum(a.u for a in f)):
        q = poly(1)
        for a in factors:
            q = q * atom(a)
        yield q


def _content_of(factors: tuple[Atom, ...]) -> tuple[int, ...]:
    """How often modes, conjugate modes, adjoint modes and conjugate adjoint modes occur."""
    count = [0, 0, 0, 0]
    for a in factors:
        if a.name in ADJOINT:
            count[2 + a.bar] += 1
        else:
            plain, starred = MODES[a.name]
            count[0 + a.bar] += plain
            count[1 - a.bar] += starred
    return tuple(count)


def _parity(factors: tuple[Atom, ...]) -> int:
    """0 for a product that the reflection u -> -u of the equations leaves, 1 for one that it turns."""
    return sum(a.u + (a.name in ODD) for a in factors) % 2


def _family(a: Atom) -> Family:
    """The family of an integral: power is that of its integrand."""
    inside = dict(integrand(a))
    power = inside.pop(U, 0)
    factors = tuple(b for b, e in inside.items() for _ in range(e))
    return Family(_content_of(factors), (_parity(factors) + power) % 2, power)


def is_known(column: Monomial) -> bool:
    """One integral, over shapes of the theory as often as they occur there."""
    integrals = [(a, e) for a, e in column if a.kind == "integral"]
    if len(integrals) != 1 or integrals[0][1] != 1:
        return False
    a, _ = integrals[0]
    letters = all(
        e > 0 and (b == U or (b.kind == "shape" and b.name in (*MODES, *ADJOINT))) for b, e in integrand(a)
    )
    return letters and sum(_family(a).content) <= FACTORS


def _parts(p: Poly) -> tuple[Poly, Poly]:
    """Real and imaginary part of the coefficients, lambda in the place of omega."""
    p = p.map(lambda a: -I * atom(LAMBDA) if a == Atom("constant", "omega") else None)
    real = Poly.of((m, QQ_I(c.x, 0)) for m, c in p.terms.items())
    return real, -I * (p - real)
