r"""Grammar nodes to syntax nodes, and what only the notation can decide.

``f(x)`` is a value when ``f`` is declared a function and the bracket holds one of its arguments or a number,
else a product. Prefixes bind after that: ``\partial_u``, ``\mathrm{Re}`` and ``\cos`` take the next factor.
"""

from __future__ import annotations

from collections.abc import Mapping
from fractions import Fraction
from itertools import pairwise
from typing import Any

from lark import Token, Transformer

from derivation.paper.syntax import (
    Abs,
    Apply,
    At,
    Conj,
    Dagger,
    Diff,
    Expr,
    Func,
    Int,
    Matrix,
    Neg,
    Num,
    Power,
    Prime,
    Quot,
    Relation,
    Rest,
    Series,
    Sum,
    Sym,
    Tuple,
    children,
)
from derivation.paper.waiting import (
    D,
    Fn,
    Mark,
    Op,
    Paren,
    Spill,
    called,
    leibniz,
    multiply,
    paren_of,
    prefixes,
    replace_paren,
    script,
    take_differential,
)

Functions = Mapping[str, tuple[str, ...]]


class Builder(Transformer[Token, Any]):
    """Grammar nodes to syntax nodes."""

    def __init__(self, functions: Functions) -> None:
        super().__init__()
        self.functions = functions

    def start(self, parts: list[Any]) -> list[tuple[str, Expr]]:
        return [("", parts[0])] + [(str(op), side) for op, side in zip(parts[1::2], parts[2::2], strict=True)]

    def sum(self, parts: list[Any]) -> Any:
        terms: list[Any] = []
        sign = "+"
        for part in parts:
            if isinstance(part, Token):
                sign = str(part)
            else:
                part, after = (part.value, part.terms) if isinstance(part, Spill) else (part, ())
                terms += [part if sign == "+" else Neg(part), *after]
                sign = "+"
        return terms[0] if len(terms) == 1 else Sum(tuple(terms))

    def product(self, parts: list[Any]) -> Any:
        """Factors in a row to one node: values of functions, then prefixes, then quotients and dots."""
        if isinstance(parts[-1], Spill):
            return Spill(self.product([*parts[:-1], parts[-1].value]), parts[-1].terms)
        items = self._apply(parts)
        if any(isinstance(a, Num) and isinstance(b, Num) for a, b in pairwise(items)):
            raise ValueError("two numbers side by side; 10 000 is written 10000")
        place = next((k for k, f in enumerate(items) if isinstance(f, D)), None)
        if place is None:
            return multiply(prefixes(items))
        d = items[place]
        after = items[place + 1 :]
        if len(after) > 1 and isinstance(after[0], Fn):
            after[:2] = [called(after[0], after[1])]
        return D(d.n, d.partial, tuple(items[:place]), after[0] if after else None, tuple(after[1:]))

    def factor(self, parts: list[Any]) -> Any:
        node = parts[0]
        powered = False
        for kind, value in parts[1:]:
            if powered and kind != "sub":
                raise ValueError("a second superscript after a power; braces or brackets tell what it is on")
            node = script(node, kind, value)
            powered = powered or (kind == "sup" and not isinstance(value, Mark))
        return node

    def sup(self, parts: list[Any]) -> tuple[str, Any]:
        return "sup", parts[1]

    def sub(self, parts: list[Any]) -> tuple[str, Any]:
        return "sub", parts[1]

    def primes(self, parts: list[Any]) -> tuple[str, Any]:
        return "prime", len(parts[0])

    def order(self, parts: list[Any]) -> tuple[str, Any]:
        return "order", str(parts[0])

    def argument(self, parts: list[Any]) -> Any:
        return next(p for p in parts if not isinstance(p, Token))

    def group(self, parts: list[Any]) -> Any:
        items = parts[1]
        return items[0] if len(items) == 1 else Tuple(tuple(items))

    def sign(self, parts: list[Any]) -> Any:
        return Mark(str(parts[1]))

    def mark(self, parts: list[Any]) -> Any:
        return Mark("star" if parts[0].type == "STAR" else "dagger")

    def items(self, parts: list[Any]) -> list[Any]:
        return [p for p in parts if not isinstance(p, Token)]

    def item(self, parts: list[Any]) -> Any:
        return parts[0] if len(parts) == 1 else Relation(str(parts[1]), parts[0], parts[2])

    def number(self, parts: list[Any]) -> Num:
        return Num(Fraction(str(parts[0])))

    def letter(self, parts: list[Any]) -> Sym:
        return Sym(str(parts[0]))

    def infinity(self, _: list[Any]) -> Num:
        return Num(None)

    def accent(self, parts: list[Any]) -> Sym:
        accent, inner = str(parts[0]), parts[1]
        if not isinstance(inner, Sym):
            raise ValueError(f"{accent} stands on something that is not a letter")
        return Sym(f"{accent}{{{inner.base}}}", inner.sub, inner.order)

    def paren(self, parts: list[Any]) -> Paren:
        return Paren(tuple(parts[1]))

    def braces(self, parts: list[Any]) -> Any:
        return parts[1]

    def bars(self, parts: list[Any]) -> Abs:
        return Abs(parts[1])

    def evaluated(self, parts: list[Any]) -> At:
        return At(parts[1], Rest("place"))

    def frac(self, parts: list[Any]) -> Any:
        num, den = parts[1], parts[2]
        if isinstance(num, D) and isinstance(den, D):
            return leibniz(num, den)
        return Quot(num, den)

    def root(self, parts: list[Any]) -> Func:
        return Func("sqrt", parts[1])

    def func(self, parts: list[Any]) -> Fn:
        return Fn(str(parts[0]))

    def partial(self, _: list[Any]) -> D:
        return D(1, partial=True)

    def differential(self, _: list[Any]) -> D:
        return D(1, partial=False)

    def integral(self, parts: list[Any]) -> Any:
        limits = dict(parts[1:-1])
        arg, var, factors, terms = take_differential(parts[-1])
        if not {"sub", "sup"} <= set(limits):
            raise ValueError(r"\int without its two limits")
        whole = multiply([Int(arg, var, limits["sub"], limits["sup"]), *prefixes(list(factors))])
        return Spill(whole, terms) if terms else whole

    def series(self, parts: list[Any]) -> Series:
        limits = dict(parts[1:-1])
        start = limits.get("sub")
        if not isinstance(start, Relation) or not isinstance(start.left, Sym) or "sup" not in limits:
            raise ValueError(r"\sum without its limits n=... and ...")
        if isinstance(parts[-1], Spill):
            raise ValueError(r"terms after an integral under \sum; put it in brackets")
        return Series(parts[-1], start.left, start.right, limits["sup"])

    def matrix(self, parts: list[Any]) -> Matrix:
        rows = tuple(p for p in parts if isinstance(p, tuple))
        if len({len(r) for r in rows}) != 1:
            raise ValueError("a matrix whose rows differ in length")
        return Matrix(rows)

    def row(self, parts: list[Any]) -> tuple[Any, ...]:
        return tuple(p for p in parts if not isinstance(p, Token))

    def atom(self, parts: list[Any]) -> Any:
        return Rest({"CC": "cc", "NST": "nst", "DOTS": "dots"}[parts[0].type])

    def _apply(self, items: list[Any]) -> list[Any]:
        out: list[Any] = []
        for item in items:
            paren = paren_of(item)
            if paren is None:
                out.append(item)
            elif out and self._is_value(out[-1], paren):
                out[-1] = replace_paren(item, Apply(out[-1], paren.items))
            else:
                content = paren.items[0] if len(paren.items) == 1 else Tuple(paren.items)
                if isinstance(content, Relation):
                    raise ValueError("a relation in brackets after something that is not a function")
                out.append(replace_paren(item, content))
        return out

    def _is_value(self, fn: Any, paren: Paren) -> bool:
        head = fn
        while isinstance(head, (Prime, Conj, Dagger, Abs, Power)):
            head = head.base if isinstance(head, Power) else head.arg
        args = self.functions.get(head.name) if isinstance(head, Sym) else None
        if args is None:
            return False
        return all(isinstance(item, Num) or _mentions(item, args) for item in paren.items)


def _mentions(node: Any, letters: tuple[str, ...]) -> bool:
    """Whether one of the letters occurs, other than as the variable of a derivative or an integral."""
    if isinstance(node, (Diff, Int, Op)):
        return (
            node.arg is not None and _mentions(node.arg, letters) if isinstance(node, (Diff, Int)) else False
        )
    return (isinstance(node, Sym) and node.name in letters) or any(
        _mentions(c, letters) for c in children(node)
    )
