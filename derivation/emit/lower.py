"""From a SymPy expression to nodes: the one place that decides which arithmetic may be emitted.

Sums, products, quotients, powers, conjugates and the functions of `FUNCTIONS` pass. Whole and half powers are
written as such, others as exp(p log x), as their author wrote them before SymPy shortened it. A rational
coefficient becomes a division by an integer as the last step (`5*x/6`), because the quotient of two literals
would already be a rounded float where x is a ball or a multiprecision number. A constant that nothing
multiplies takes its number type from an argument: 3/2 is emitted as `(3 + 0*k1)/2`.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import sympy

from derivation.emit.nodes import (
    Call,
    Imaginary,
    Integer,
    Name,
    Negative,
    Node,
    Power,
    Product,
    Quotient,
    Sum,
)

FUNCTIONS = {sympy.sin: "sin", sympy.cos: "cos", sympy.exp: "exp", sympy.log: "log"}  # sqrt is a power


class EmissionError(ValueError):
    """An expression or a record cannot become code; the message names the part and the remedy."""


def _refuse(expr: sympy.Basic) -> Node:
    raise EmissionError(
        f"{expr} cannot be written as code: it may hold names, whole numbers, sums, products, quotients, "
        "powers, conjugates, and sin, cos, exp, log, sqrt"
    )


def _text(symbol: sympy.Symbol) -> str:
    return str(symbol.name)


@dataclass(frozen=True)
class Lowering:
    """Translates expressions; `name` spells a symbol, `opaque` is what happens to a foreign node.

    `exact` keeps quotients of literals out (emitted code); without it 1/2 stays 1/2 (text for readers).
    `carrier` is the name of an argument, a finite number, that gives its type to a bare constant; without one
    such constants are refused.
    """

    name: Callable[[sympy.Symbol], str] = _text
    opaque: Callable[[sympy.Basic], Node] = _refuse
    exact: bool = True
    carrier: str = ""

    def __call__(self, expr: sympy.Expr) -> Node:
        match expr:
            case sympy.Symbol():
                return Name(self.name(expr))
            case sympy.Integer():
                return _signed(Integer(abs(int(expr))), negative=bool(expr < 0))
            case sympy.Rational():
                return self._rational(expr)
            case sympy.Add():
                return self._sum(expr)
            case sympy.Mul():
                return self._product(expr)
            case sympy.Pow(base=base, exp=sympy.Rational()) if base is not sympy.E and expr.exp.q in (1, 2):
                return self._product(expr)
            case sympy.Pow(base=base, exp=exponent) if base is not sympy.E:
                return Call("exp", self(exponent * sympy.log(base)))
            case sympy.conjugate(args=(operand,)):
                return Call("conjugate", self(operand))
        if expr is sympy.I:
            return Imaginary()
        if expr is sympy.E:  # what SymPy makes of exp(1)
            return Call("exp", Integer(1))
        if expr.func in FUNCTIONS:
            return Call(FUNCTIONS[expr.func], self(expr.args[0]))
        return self.opaque(expr)

    def _rational(self, number: sympy.Rational) -> Node:
        numerator = self._carried(number.p, number) if self.exact else Integer(abs(number.p))
        return _signed(Quotient(numerator, Integer(number.q)), negative=bool(number < 0))

    def _carried(self, numerator: int, constant: sympy.Expr) -> Node:
        """The numerator of a bare constant, in the number type of the carrier."""
        if not self.carrier:
            raise EmissionError(f"the bare constant {constant} would be rounded: multiply it by an argument")
        return Sum((Integer(abs(numerator)), Product((Integer(0), Name(self.carrier)))))

    def _sum(self, expr: sympy.Add) -> Node:
        constant, rest = expr.as_coeff_Add()
        fraction = constant.is_Rational and constant.q != 1 and rest.free_symbols
        if self.exact and fraction:  # x + 1/2 = (2x + 1)/2
            whole = sympy.Add(constant.p, *(constant.q * term for term in sympy.Add.make_args(rest)))
            return Quotient(self(whole), Integer(constant.q))
        terms = [self(term) for term in sympy.ordered(expr.args)]
        leading = next((i for i, term in enumerate(terms) if not isinstance(term, Negative)), 0)
        return Sum((terms[leading], *terms[:leading], *terms[leading + 1 :]))

    def _product(self, expr: sympy.Expr) -> Node:
        coefficient, rest = expr.as_coeff_Mul()
        if not coefficient.is_Rational:  # 2.5*x
            return self.opaque(coefficient)
        literal = _literal(abs(coefficient.p))
        if self.exact and coefficient.q != 1 and not rest.free_symbols:  # i/3
            literal = [self._carried(coefficient.p, expr)]
        above: list[Node] = []
        below: list[Node] = []
        for factor in sympy.ordered(sympy.Mul.make_args(rest)):
            base, exponent = factor.as_base_exp()
            if exponent.is_Rational and exponent.q in (1, 2) and base not in (sympy.E, sympy.S.NegativeOne):
                side = above if exponent > 0 else below
                side.append(self._power(base, abs(exponent)))
            else:
                above.append(self(factor))
        negative = bool(coefficient < 0)
        for i, factor in enumerate(above):
            terms = factor.terms if isinstance(factor, Sum) else ()
            opposite = tuple(term.operand for term in terms if isinstance(term, Negative))
            if terms and len(opposite) == len(terms):  # a (-b - c) = -a (b + c)
                above[i] = Sum(opposite)
                negative = not negative
        node = _multiplied(literal + above)
        if below or coefficient.q != 1:
            node = Quotient(node, _multiplied(_literal(coefficient.q) + below))
        return _signed(node, negative)

    def _power(self, base: sympy.Expr, exponent: sympy.Rational) -> Node:
        node = self(base) if exponent.q == 1 else Call("sqrt", self(base))
        return node if exponent.p == 1 else Power(node, int(exponent.p))


def _signed(node: Node, negative: bool) -> Node:
    return Negative(node) if negative else node


def _literal(value: int) -> list[Node]:
    return [] if value == 1 else [Integer(int(value))]


def _multiplied(factors: list[Node]) -> Node:
    if len(factors) > 1:
        return Product(tuple(factors))
    return factors[0] if factors else Integer(1)
