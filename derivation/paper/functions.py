"""Roots, absolute values and e^{ip} of an element of the algebra, in one form where it is known."""

from __future__ import annotations

from math import isqrt

from derivation.paper.algebra import ONE, POSITIVE, Atom, I, Poly, atom, exp, is_positive, poly, rational
from derivation.paper.values import integer

#: Sines and cosines of at most so many times theta are written out.
MOST_TURNS = 12


def root(p: Poly) -> Poly:
    """The square root; of a square number, and of a power of a letter that is positive, a known one."""
    if len(p.terms) != 1 or not is_positive(p):
        return atom(Atom("sqrt", arg=p))
    ((m, c),) = p.terms.items()
    numerator, denominator = (isqrt(int(x)) for x in (c.x.numerator, c.x.denominator))
    if numerator**2 != c.x.numerator or denominator**2 != c.x.denominator:
        return atom(Atom("sqrt", arg=p))
    total = rational(numerator, denominator)
    rest = poly(1)
    for a, e in m:
        whole = e // 2 if a.kind == "constant" and a.name in POSITIVE else 0
        total, rest = total * atom(a) ** whole, rest * atom(a) ** (e - 2 * whole)
    return total if rest == poly(1) else total * atom(Atom("sqrt", arg=rest))


def modulus(p: Poly) -> Poly:
    """|p|; of a product that of each factor."""
    if len(p.terms) > 1:
        return atom(Atom("sqrt", "abs", arg=p * p.conjugate()))
    total = poly(1)
    for m, c in p.terms.items():
        total = root(Poly({ONE: c}) * Poly({ONE: c}).conjugate())
        for a, e in m:
            total = total * root(atom(a) * atom(a).conjugate()) ** e
    return total if p else p


def turned(p: Poly) -> Poly:
    """e^{i p}; of a multiple of theta in the sine and cosine in which the theory has it."""
    for place in (None, 0, 1):
        theta = Atom("exact", "theta", place=place)
        times = integer(p * atom(theta).inverse()) if theta in p.atoms else None
        if times is not None and abs(times) <= MOST_TURNS:
            cos, sin = (atom(theta.replace(name=name)) for name in ("cos", "sin"))
            return (cos + I * sin) ** times if times > 0 else (cos - I * sin) ** -times
    return exp(I * p)
