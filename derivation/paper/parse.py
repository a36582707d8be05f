r"""Tokens of one equation to its syntax tree: a LALR grammar, then what only the notation can decide.

``f(x)`` is a value when ``f`` is declared a function and the bracket holds one of its arguments or a number,
else a product. Prefixes bind after that: ``\partial_u``, ``\mathrm{Re}`` and ``\cos`` take the next factor.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction
from functools import cache
from pathlib import Path
from typing import Any

from lark import Lark, Token, Transformer
from lark.exceptions import UnexpectedInput, UnexpectedToken, VisitError
from lark.lexer import Lexer

from derivation.errors import ReadError
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
    children,
    walk,
)
from derivation.paper.tokens import NAMES, tokenize

Functions = Mapping[str, tuple[str, ...]]


class _Ready(Lexer):
    """The tokens are made elsewhere (:mod:`derivation.paper.tokens`)."""

    def __init__(self, lexer_conf: Any) -> None:
        pass

    def lex(self, tokens: Iterable[Token]) -> Iterator[Token]:  # type: ignore[override]
        yield from tokens


@cache
def _parser() -> Lark:
    text = Path(__file__).with_name("grammar.lark").read_text(encoding="utf-8")
    return Lark(text, parser="lalr", lexer=_Ready)


def parse(tokens: Sequence[Token], functions: Functions) -> list[tuple[str, Expr]]:
    """A chain ``a = b = c`` as its members, each with the relation before it ('' for the first).

    Raises:
        ReadError: with the line and what was expected there.
    """
    if not tokens:
        raise ReadError(1, "an empty equation")
    last = tokens[-1].line or 1
    try:
        tree = _parser().parse(tokens)
        chain: list[tuple[str, Expr]] = _Builder(functions).transform(tree)
    except UnexpectedToken as error:
        raise ReadError(error.token.line or last, _expected(error)) from None
    except UnexpectedInput as error:
        raise ReadError(last, str(error)) from None
    except VisitError as error:
        raise ReadError(tokens[0].line or 1, str(error.orig_exc)) from None
    for _, side in chain:
        for node in walk(side):
            if isinstance(node, (_Paren, _Op, _Fn, _D)):
                raise ReadError(tokens[0].line or 1, f"{node.shown} has nothing to act on")
    return chain


def expression(latex: str, functions: Functions | None = None, line: int = 1) -> Expr:
    """One expression (no relation) from LaTeX."""
    chain = parse(tokenize(latex, line), functions or {})
    if len(chain) != 1:
        raise ReadError(line, "a relation where an expression was expected")
    return chain[0][1]


def letter_name(latex: str) -> str:
    """The one spelling of a letter: ``\\tilde k_1`` and ``\\tilde{k}_{1}`` are the same."""
    node = expression(latex)
    if not isinstance(node, Sym) or node.order:
        raise ReadError(1, f"{latex!r} is not a letter with accents and a subscript")
    return node.name


def _expected(error: UnexpectedToken) -> str:
    found = "the end of the equation" if error.token.type == "$END" else repr(str(error.token))
    wanted = sorted({NAMES[t] for t in error.accepts or error.expected if t in NAMES})
    return f"unexpected {found}; expected {', '.join(wanted) or 'another symbol'}"


# What stands between the grammar and the syntax tree: never leaves this module.
@dataclass(frozen=True)
class _Paren:
    items: tuple[Any, ...]
    shown = "a bracket"


@dataclass(frozen=True)
class _Op:
    """A derivative waiting for its operand."""

    var: Sym
    n: int
    partial: bool
    shown = "a derivative"


@dataclass(frozen=True)
class _Fn:
    name: str
    power: Expr | None = None
    shown = "a function"


@dataclass(frozen=True)
class _D:
    """``d`` or a bare ``\\partial``, with what stands before, at and after it in its product."""

    n: int
    partial: bool
    before: tuple[Any, ...] = ()
    arg: Any = None
    after: tuple[Any, ...] = ()
    shown = "a differential"


@dataclass(frozen=True)
class _Mark:
    kind: str
    shown = "a mark"


class _Builder(Transformer[Token, Any]):
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
                terms.append(part if sign == "+" else Neg(part))
                sign = "+"
        return terms[0] if len(terms) == 1 else Sum(tuple(terms))

    def product(self, parts: list[Any]) -> Any:
        """Factors in a row to one node: values of functions, then prefixes, then quotients and dots."""
        items = self._apply(parts)
        place = next((k for k, f in enumerate(items) if isinstance(f, _D)), None)
        if place is None:
            return _multiply(_prefixes(items))
        d = items[place]
        after = items[place + 1 :]
        if len(after) > 1 and isinstance(after[0], _Fn):
            after[:2] = [_called(after[0], after[1])]
        return _D(d.n, d.partial, tuple(items[:place]), after[0] if after else None, tuple(after[1:]))

    def factor(self, parts: list[Any]) -> Any:
        node = parts[0]
        for kind, value in parts[1:]:
            node = _script(node, kind, value)
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
        return _Mark(str(parts[1]))

    def mark(self, parts: list[Any]) -> Any:
        return _Mark("star" if parts[0].type == "STAR" else "dagger")

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

    def paren(self, parts: list[Any]) -> _Paren:
        return _Paren(tuple(parts[1]))

    def braces(self, parts: list[Any]) -> Any:
        return parts[1]

    def bars(self, parts: list[Any]) -> Abs:
        return Abs(parts[1])

    def evaluated(self, parts: list[Any]) -> At:
        return At(parts[1], Rest("place"))

    def frac(self, parts: list[Any]) -> Any:
        num, den = parts[1], parts[2]
        if isinstance(num, _D) and isinstance(den, _D):
            return _leibniz(num, den)
        return Quot(num, den)

    def root(self, parts: list[Any]) -> Func:
        return Func("sqrt", parts[1])

    def func(self, parts: list[Any]) -> _Fn:
        return _Fn(str(parts[0]))

    def partial(self, _: list[Any]) -> _D:
        return _D(1, partial=True)

    def differential(self, _: list[Any]) -> _D:
        return _D(1, partial=False)

    def integral(self, parts: list[Any]) -> Int:
        limits = dict(parts[1:-1])
        arg, var = _take_differential(parts[-1])
        if not {"sub", "sup"} <= set(limits):
            raise ValueError(r"\int without its two limits")
        return Int(arg, var, limits["sub"], limits["sup"])

    def series(self, parts: list[Any]) -> Series:
        limits = dict(parts[1:-1])
        start = limits.get("sub")
        if not isinstance(start, Relation) or not isinstance(start.left, Sym) or "sup" not in limits:
            raise ValueError(r"\sum without its limits n=... and ...")
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
            paren = _paren_of(item)
            if paren is None:
                out.append(item)
            elif out and self._is_value(out[-1], paren):
                out[-1] = _replace_paren(item, Apply(out[-1], paren.items))
            else:
                content = paren.items[0] if len(paren.items) == 1 else Tuple(paren.items)
                if isinstance(content, Relation):
                    raise ValueError("a relation in brackets after something that is not a function")
                out.append(_replace_paren(item, content))
        return out

    def _is_value(self, fn: Any, paren: _Paren) -> bool:
        head = fn
        while isinstance(head, (Prime, Conj, Dagger)):
            head = head.arg
        args = self.functions.get(head.name) if isinstance(head, Sym) else None
        if args is None:
            return False
        return all(isinstance(item, Num) or _mentions(item, args) for item in paren.items)


def _mentions(node: Any, letters: tuple[str, ...]) -> bool:
    """Whether one of the letters occurs, other than as the variable of a derivative or an integral."""
    if isinstance(node, (Diff, Int, _Op)):
        return (
            node.arg is not None and _mentions(node.arg, letters) if isinstance(node, (Diff, Int)) else False
        )
    return (isinstance(node, Sym) and node.name in letters) or any(
        _mentions(c, letters) for c in children(node)
    )


def _script(node: Any, kind: str, value: Any) -> Any:
    if kind == "prime":
        return Prime(node.arg, node.n + value) if isinstance(node, Prime) else Prime(node, value)
    if kind == "order":
        return _with_order(node, value)
    if kind == "sub":
        return _with_subscript(node, value)
    if isinstance(value, _Mark):
        if value.kind in "+-":
            raise ValueError(f"a lone {value.kind} as superscript")
        return Conj(node) if value.kind == "star" else Dagger(node)
    if isinstance(node, _Fn):
        return _Fn(node.name, value)
    if isinstance(node, (_Op, _D)):
        n = _small_integer(value)
        return _Op(node.var, n, node.partial) if isinstance(node, _Op) else _D(n, node.partial)
    if node == Sym("e"):
        return Func("exp", value)
    return Power(node, value)


def _with_subscript(node: Any, value: Any) -> Any:
    if isinstance(node, Sym) and not node.sub:
        return Sym(node.base, _text(value), node.order)
    if isinstance(node, _D) and node.partial and isinstance(value, Sym):
        return _Op(value, node.n, partial=True)
    if isinstance(node, At):
        return At(node.arg, value)
    if isinstance(node, _Paren) and len(node.items) == 2:
        return Tuple(node.items, value)
    raise ValueError("a subscript on something that is not a letter")


def _with_order(node: Any, order: str) -> Any:
    if isinstance(node, Prime):
        return Prime(_with_order(node.arg, order), node.n)
    if isinstance(node, Sym) and not node.order:
        return Sym(node.base, node.sub, order)
    raise ValueError(f"an order ({order}) on something that is not a letter")


def _small_integer(value: Any) -> int:
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
    if isinstance(value, _Mark):
        return "*" if value.kind == "star" else value.kind
    raise ValueError("a subscript that is not made of letters and numbers")


def _paren_of(item: Any) -> _Paren | None:
    while isinstance(item, (Power, Conj, Prime, Dagger)):
        item = item.base if isinstance(item, Power) else item.arg
    return item if isinstance(item, _Paren) else None


def _replace_paren(item: Any, new: Any) -> Any:
    if isinstance(item, _Paren):
        return new
    if isinstance(item, Power):
        return Power(_replace_paren(item.base, new), item.exponent)
    if isinstance(item, Prime):
        return Prime(_replace_paren(item.arg, new), item.n)
    return type(item)(_replace_paren(item.arg, new))


def _prefixes(items: list[Any]) -> list[Any]:
    """From the right: each prefix takes the factor after it; a derivative at the end stays an operator."""
    out: list[Any] = []
    for item in reversed(items):
        if isinstance(item, _Op):
            ready = bool(out) and not isinstance(out[0], Token)
            out.insert(0, Diff(out.pop(0) if ready else None, item.var, item.n, item.partial))
        elif isinstance(item, _Fn):
            if not out or isinstance(out[0], Token):
                raise ValueError(f"{item.name} without an argument")
            out.insert(0, _called(item, out.pop(0)))
        else:
            out.insert(0, item)
    return out


def _called(fn: _Fn, arg: Any) -> Any:
    value = Func(fn.name, arg)
    return value if fn.power is None else Power(value, fn.power)


def _multiply(items: list[Any]) -> Any:
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


def _leibniz(num: _D, den: _D) -> Any:
    """``dA/dT`` or the operator ``d/dR``."""
    var, n = (den.arg.base, _small_integer(den.arg.exponent)) if isinstance(den.arg, Power) else (den.arg, 1)
    if not isinstance(var, Sym) or n != num.n or num.before or den.before or den.after:
        raise ValueError("a quotient of differentials that is not a derivative")
    op = _Op(var, n, num.partial)
    if num.arg is None:
        return op
    return Diff(_multiply(_prefixes([num.arg, *num.after])), var, n, num.partial)


def _take_differential(node: Any) -> tuple[Any, Sym]:
    """The integrand and the variable of ``du f + g`` or ``f du``."""
    terms = list(node.terms) if isinstance(node, Sum) else [node]
    for place, term in ((0, terms[0]), (len(terms) - 1, terms[-1])):
        d = term.arg if isinstance(term, Neg) else term
        if isinstance(d, _D) and isinstance(d.arg, Sym):
            rest = [*d.before, *d.after]
            new = _multiply(_prefixes(rest)) if rest else Num(Fraction(1))
            terms[place] = Neg(new) if isinstance(term, Neg) else new
            return (terms[0] if len(terms) == 1 else Sum(tuple(terms))), d.arg
    raise ValueError(r"\int without d and its variable")


__all__ = ["Node", "expression", "letter_name", "parse"]
