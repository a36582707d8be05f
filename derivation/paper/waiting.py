"""What stands between the grammar and the syntax tree while an equation is built, and how it is resolved.

A bracket waits to learn whether it is an argument, a prefix (``\\partial_u``, ``\\cos``) for its operand, a
``d`` for the fraction or the integral that it belongs to. None of these leaves the parser.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from fractions import Fraction
from typing import Any

from lark import Token

from derivation.paper.syntax import (
    At,
    Conj,
    Dagger,
    Diff,
    Dot,
    Expr,
    Func,
    Neg,
    Num,
    Power,
    Prime,
    Prod,
    Quot,
    Relation,
    Sum,
    Sym,
    Tuple,
)


@dataclass(frozen=True)
class Paren:
    items: tuple[Any, ...]
    shown = "a bracket"


@dataclass(frozen=True)
class Op:
    """A derivative waiting for its operand."""

    var: Sym
    n: int
    partial: bool
    shown = "a derivative"


@dataclass(frozen=True)
class Fn:
    name: str
    power: Expr | None = None
    shown = "a function"


@dataclass(frozen=True)
class D:
    """``d`` or a bare ``\\partial``, with what stands before, at and after it in its product."""

    n: int
    partial: bool
    before: tuple[Any, ...] = ()
    arg: Any = None
    after: tuple[Any, ...] = ()
    shown = "a differential"


@dataclass(frozen=True)
class Spill:
    """An integral that its differential ended, and the terms after it, which belong to the sum around it."""

    value: Any
    terms: tuple[Any, ...]
    shown = "an integral"


@dataclass(frozen=True)
class Mark:
    kind: str
    shown = "a mark"


def script(node: Any, kind: str, value: Any) -> Any:
    if isinstance(node, Num) and (kind != "sup" or isinstance(value, Mark)):
        raise ValueError("a prime, a mark or a subscript on a number")
    if isinstance(value, (Tuple, Relation)) and kind == "sup":
        raise ValueError("a list or a relation as superscript")
    if kind == "prime":
        return Prime(node.arg, node.n + value) if isinstance(node, Prime) else Prime(node, value)
    if kind == "order":
        return _with_order(node, value)
    if kind == "sub":
        return _with_subscript(node, value)
    if isinstance(value, Mark):
        if value.kind in "+-":
            raise ValueError(f"a lone {value.kind} as superscript")
        return Conj(node) if value.kind == "star" else Dagger(node)
    if isinstance(node, Fn):
        if isinstance(value, Neg):
            raise ValueError(f"{node.name} to a negative power: an inverse function or a quotient?")
        return Fn(node.name, value)
    if isinstance(node, (Op, D)):
        n = small_integer(value)
        return Op(node.var, n, node.partial) if isinstance(node, Op) else D(n, node.partial)
    if node == Sym("e"):
        return Func("exp", value)
    return Power(node, value)


def _with_subscript(node: Any, value: Any) -> Any:
    if isinstance(node, (Prime, Conj, Dagger)):
        return replace(node, arg=_with_subscript(node.arg, value))
    if isinstance(node, Sym) and not node.sub:
        return Sym(node.base, _text(value), node.order)
    if isinstance(node, D) and node.partial and isinstance(value, Sym):
        return Op(value, node.n, partial=True)
    if isinstance(node, At):
        return At(node.arg, value)
    if isinstance(node, Paren) and len(node.items) == 2:
        return Tuple(node.items, value)
    raise ValueError("a subscript on something that is not a letter")


def _with_order(node: Any, order: str) -> Any:
    if isinstance(node, (Prime, Conj, Dagger)):
        return replace(node, arg=_with_order(node.arg, order))
    if isinstance(node, Sym) and not node.order:
        return Sym(node.base, node.sub, order)
    raise ValueError(f"an order ({order}) on something that is not a letter")


def small_integer(value: Any) -> int:
    if (
        isinstance(value, Num)
        and value.value is not None
        and value.value.denominator == 1
        and 0 < value.value < 10
    ):
        return int(value.value)
    raise ValueError("a derivative to a power that is not a small positive integer")


def _text(value: Any) -> str:
    """A subscript as text, without blanks."""
    if isinstance(value, Sym) and not value.order:
        return value.name
    if isinstance(value, Num) and value.value is not None:
        return str(value.value)
    if isinstance(value, Prod):
        return "".join(map(_text, value.factors))
    if isinstance(value, Tuple):
        return ",".join(map(_text, value.items))
    if isinstance(value, Mark):
        return "*" if value.kind == "star" else value.kind
    raise ValueError("a subscript that is not made of letters and numbers")


def paren_of(item: Any) -> Paren | None:
    while isinstance(item, (Power, Conj, Prime, Dagger)):
        item = item.base if isinstance(item, Power) else item.arg
    return item if isinstance(item, Paren) else None


def replace_paren(item: Any, new: Any) -> Any:
    if isinstance(item, Paren):
        return new
    if isinstance(item, Power):
        return Power(replace_paren(item.base, new), item.exponent)
    if isinstance(item, Prime):
        return Prime(replace_paren(item.arg, new), item.n)
    return type(item)(replace_paren(item.arg, new))


def prefixes(items: list[Any]) -> list[Any]:
    """From the right: each prefix takes the factor after it; a derivative at the end stays an operator."""
    out: list[Any] = []
    for item in reversed(items):
        if isinstance(item, Op):
            ready = bool(out) and not isinstance(out[0], Token)
            out.insert(0, Diff(out.pop(0) if ready else None, item.var, item.n, item.partial))
        elif isinstance(item, Fn):
            if not out or isinstance(out[0], Token):
                raise ValueError(f"{item.name} without an argument")
            if len(out) > 1 and isinstance(out[0], Num) and not isinstance(out[1], Token):
                raise ValueError(f"{item.name} of a number and more; brackets tell what it is of")
            out.insert(0, called(item, out.pop(0)))
        else:
            out.insert(0, item)
    return out


def called(fn: Fn, arg: Any) -> Any:
    value = Func(fn.name, arg)
    return value if fn.power is None else Power(value, fn.power)


def multiply(items: list[Any]) -> Any:
    """Left to right: ``/`` divides by the next factor, a dot pairs two vectors."""
    factors: list[Any] = []
    operator: Token | None = None
    for item in items:
        if isinstance(item, Token):
            operator = item
            continue
        if operator is not None and operator.type == "OVER":
            factors = [Quot(_product(factors), item)]
        elif operator is not None and str(operator) == ".":
            factors = [*factors[:-1], Dot(factors[-1], item)]
        else:
            factors.append(item)
        operator = None
    return _product(factors)


def _product(factors: list[Any]) -> Any:
    return factors[0] if len(factors) == 1 else Prod(tuple(factors))


def leibniz(num: D, den: D) -> Any:
    """``dA/dT`` or the operator ``d/dR``."""
    var, n = (den.arg.base, small_integer(den.arg.exponent)) if isinstance(den.arg, Power) else (den.arg, 1)
    if not isinstance(var, Sym) or n != num.n or num.before or den.before or den.after:
        raise ValueError("a quotient of differentials that is not a derivative")
    op = Op(var, n, num.partial)
    if num.arg is None:
        return op
    return Diff(multiply(prefixes([num.arg, *num.after])), var, n, num.partial)


def take_differential(node: Any) -> tuple[Any, Sym, tuple[Any, ...], tuple[Any, ...]]:
    """Of ``du f + g`` or ``f + g du h + k``: integrand, variable, the factors and the terms after it."""
    terms = node.terms if isinstance(node, Sum) else (node,)
    for place, term in enumerate(terms):
        d = term.arg if isinstance(term, Neg) else term
        if not (isinstance(d, D) and isinstance(d.arg, Sym)):
            continue
        if leads := place == 0 and not d.before:
            inside, factors, rest = d.after, (), terms[1:]
        else:
            inside, factors, rest = d.before, d.after, terms[place + 1 :]
        new = multiply(prefixes(list(inside))) if inside else Num(Fraction(1))
        new = Neg(new) if isinstance(term, Neg) else new
        whole = (new, *rest) if leads else (*terms[:place], new)
        integrand = whole[0] if len(whole) == 1 else Sum(whole)
        return integrand, d.arg, factors, () if leads else rest
    raise ValueError(r"\int without d and its variable")
