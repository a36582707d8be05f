"""Tokens of one equation to its syntax tree, by a LALR grammar (grammar.lark)."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from functools import cache
from pathlib import Path
from typing import Any

from lark import Lark, Token
from lark.exceptions import UnexpectedInput, UnexpectedToken, VisitError
from lark.lexer import Lexer

from derivation.errors import ReadError
from derivation.paper.build import Builder, Functions
from derivation.paper.syntax import (
    Expr,
    Rest,
    Sym,
    walk,
)
from derivation.paper.tokens import NAMES, tokenize
from derivation.paper.waiting import D, Fn, Mark, Op, Paren


class _Ready(Lexer):
    """The tokens are made elsewhere (:mod:`derivation.paper.tokens`)."""

    def __init__(self, lexer_conf: Any) -> None:
        pass

    def lex(self, tokens: Iterable[Token]) -> Iterator[Token]:  # type: ignore[override]
        yield from tokens


@cache
def _parser() -> Lark:
    text = Path(__file__).with_name("grammar.lark").read_text(encoding="utf-8")
    return Lark(text, parser="lalr", lexer=_Ready, propagate_positions=True)


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
        chain: list[tuple[str, Expr]] = Builder(functions).transform(tree)
    except UnexpectedToken as error:
        raise ReadError(error.token.line or last, _expected(error)) from None
    except UnexpectedInput as error:
        raise ReadError(last, str(error)) from None
    except VisitError as error:
        line = getattr(getattr(error.obj, "meta", None), "line", tokens[0].line)
        raise ReadError(line or 1, str(error.orig_exc)) from None
    for _, side in chain:
        for node in walk(side):
            if isinstance(node, (Paren, Op, Fn, D, Mark)):
                raise ReadError(tokens[0].line or 1, f"{node.shown} has nothing to act on")
            if node == Rest("place"):
                raise ReadError(tokens[0].line or 1, r"\right| without a place below it, such as _{u=1}")
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
