"""From ring elements to SymPy expressions that a person would write.

A polynomial is grouped by its coefficients in the parameters: terms whose coefficients agree up to a number
share one bracket, so that c1 * (a b + 2 c d) + c2 * (...) appears, as on paper. The result is equal to the
polynomial; only its shape is chosen here.
"""

from __future__ import annotations

from typing import Any

from sympy import Add, Expr, I, Integer, Mul, Rational
from sympy.polys.rings import PolyElement

from derivation.jets import JetRing
from derivation.symbols import symbol

_PARAMETERS = {
    *("k1", "k2", "gamma1", "gamma3", "force", "nu", "mu", "k1_inv", "k2_inv", "omega", "lam"),
    *("alpha_re", "alpha_im", "beta_re", "beta_im"),
}
_INVERSES = {"k1_inv": "k1", "k2_inv": "k2"}


def expression(ring: JetRing, p: PolyElement) -> Expr:
    """``p`` as an expression, grouped by coefficients; ``k1_inv`` becomes 1/k1."""
    if not p:
        return Integer(0)
    fields = [ring[name] for name in ring.names_of(p) if name not in _PARAMETERS]
    groups: dict[PolyElement, list[Expr]] = {}
    for monomial, coefficient in ring.parts(p, fields).items():
        number, primitive = _normalised(coefficient)
        groups.setdefault(primitive, []).append(_number(number) * _monomial(ring, monomial))
    return Add(*(_product(ring, c, Add(*terms)) for c, terms in groups.items()))


def with_eigenvalue(ring: JetRing, p: PolyElement) -> PolyElement:
    """i omega written as lam, so that no imaginary literal is left at the threshold."""
    return ring.apply(p, {ring["omega"]: -ring.i * ring["lam"]})


def _normalised(c: PolyElement) -> tuple[Any, PolyElement]:
    """(number, c / number), the number rational, so that i stays with the coefficient: i omega (...)."""
    # The lowest-degree term carries the sign and the number: (1 - k2/k1), not -(k2/k1 - 1).
    lead = min(c.terms(), key=lambda t: (sum(t[0]), t[0]))[1]
    number = c.ring.domain(lead.x or lead.y)
    return number, c.quo_ground(number)


def _product(ring: JetRing, coefficient: PolyElement, bracket: Expr) -> Expr:
    common = _common_monomial(coefficient)
    rest = coefficient.exquo(common)
    factor = _monomial(ring, common)
    if all(not c.x for c in rest.coeffs()):
        rest, factor = rest.mul_ground(rest.ring.domain(0, -1)), I * factor
    polynomial = Add(
        *(
            _number(c) * _monomial(ring, ring.ring.from_dict({m: ring.ring.domain.one}))
            for m, c in rest.terms()
        )
    )
    return Mul(factor, polynomial, bracket)


def _common_monomial(p: PolyElement) -> PolyElement:
    low = tuple(min(degrees) for degrees in zip(*p.monoms(), strict=True))
    return p.ring.from_dict({low: p.ring.domain.one})


def _monomial(ring: JetRing, m: PolyElement) -> Expr:
    factors = []
    for name, e in zip(ring.names, m.leading_expv(), strict=True):
        if e:
            factors.append(symbol(_INVERSES[name]) ** -e if name in _INVERSES else symbol(name) ** e)
    return Mul(*factors)


def _number(c: Any) -> Expr:
    """A Gaussian rational as an expression."""
    x, y = c.x, c.y
    return Rational(int(x.numerator), int(x.denominator)) + I * Rational(int(y.numerator), int(y.denominator))
