"""A paper's LaTeX to its equations: scan, cut, parse. One :class:`Equation` for each printed equality."""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

from lark import Token

from derivation.errors import ReadError
from derivation.paper.notation import Notation
from derivation.paper.parse import parse
from derivation.paper.pieces import Piece, split
from derivation.paper.scan import Cell, Display, Inline, Table, scan
from derivation.paper.syntax import Equation, Expr, Num, Relation, Sym, Tuple
from derivation.paper.tokens import tokenize

MAX_EQUATIONS = 2_000
Named = tuple[str, Equation]


@dataclass(frozen=True)
class Paper:
    """What was read: the equations in their order, and the tables."""

    equations: tuple[Equation, ...]
    tables: tuple[Table, ...]


def read(text: str, notation: Notation) -> Paper:
    """Read every displayed equation, the inline definitions that the notation asks for, and the tables.

    A chain ``a = b = c`` gives ``a = b`` and ``a = c``; ``a = b = 0`` gives ``a = 0`` and ``b = 0``. The
    cells of a table that hold an equation are equations too, ``tab:summary.1``.

    Raises:
        ReadError: with the line and what was expected there.
    """
    source = scan(text)
    groups = [list(_equations(display, notation)) for display in source.displays]
    groups += [[one] for one in _inline(source.inline, notation)]
    groups += [list(_table_definitions(table, notation)) for table in source.tables]
    groups = sorted(filter(None, groups), key=lambda group: group[0][1].line)
    equations = tuple(_numbered(groups))
    if len(equations) > MAX_EQUATIONS:
        raise ReadError(equations[MAX_EQUATIONS].line, f"more than {MAX_EQUATIONS} equations")
    return Paper(equations, source.tables)


def _numbered(groups: list[list[Named]]) -> Iterator[Equation]:
    """``eq:x.1``, ``eq:x.2``; a label that comes back in another display is ``eq:x#2.1``."""
    uses: Counter[str] = Counter()
    for group in groups:
        seen: Counter[str] = Counter()
        for label, equation in group:
            uses[label] += not seen[label]
            seen[label] += 1
            name = label if uses[label] == 1 else f"{label}#{uses[label]}"
            yield replace(equation, label=name if label.startswith("inline ") else f"{name}.{seen[label]}")


def _equations(display: Display, notation: Notation) -> Iterator[Named]:
    pieces = split(tokenize(display.text, display.text_line))
    said = _said_place(display, notation)
    chains = [(piece, parse(piece.tokens, notation.functions)) for piece in pieces]
    if not any(len(chain) > 1 for piece, chain in chains if not piece.is_place):
        items = [chain[0][1] for piece, chain in chains if not piece.is_place]
        if items:
            latex = _latex([t for piece in pieces for t in piece.tokens], display.text)
            label = pieces[0].label or display.after
            yield label, Equation("", display.line, latex, Tuple(tuple(items)), None, said)
        return
    waiting: list[Named] = []
    for piece, chain in chains:
        label = piece.label or display.after
        if piece.is_place:
            place = _relation(chain, piece)
            yield from ((name, replace(e, place=place)) for name, e in waiting)
            waiting = []
            continue
        if len(chain) == 1:
            raise ReadError(
                piece.tokens[0].line or display.line, "a formula without a relation among equations"
            )
        for body in _pairs(chain):
            waiting.append(
                (label, Equation("", display.line, _latex(piece.tokens, display.text), body, None, said))
            )
    yield from waiting


def _pairs(chain: list[tuple[str, Expr]]) -> list[Relation]:
    sides = [side for _, side in chain]
    if len(chain) > 2 and isinstance(sides[-1], Num):
        return [Relation(chain[-1][0], side, sides[-1]) for side in sides[:-1]]
    return [Relation(op, sides[0], side) for op, side in chain[1:]]


def _relation(chain: list[tuple[str, Expr]], piece: Piece) -> Relation:
    if len(chain) != 2:
        raise ReadError(piece.tokens[0].line or 1, "expected a place such as u = 1 after 'at'")
    return Relation(chain[1][0], chain[0][1], chain[1][1])


def _said_place(display: Display, notation: Notation) -> Relation | None:
    """``at $u = 1$``, the last formula in the unfinished sentence that leads to the display."""
    if match := re.search(r"\bat\s+\$([^$]*)\$[^$.]*$", display.intro):
        try:
            chain = parse(tokenize(match[1], display.line), notation.functions)
        except ReadError:
            return None
        if len(chain) == 2 and chain[0][1] == Sym("u"):
            return Relation(chain[1][0], chain[0][1], chain[1][1])
    return None


def _inline(formulas: tuple[Inline, ...], notation: Notation) -> Iterator[Named]:
    """``$\\nu = 1 - F/k_1$``: a letter whose definition is looked for, and what it is set equal to."""
    for formula in formulas:
        try:
            chain = parse(tokenize(formula.text, formula.line), notation.functions)
        except ReadError:
            continue  # running text holds formulas of every kind; only definitions are wanted
        if len(chain) != 2 or not isinstance(chain[0][1], Sym):
            continue
        quantity = notation.quantity(chain[0][1].name)
        if quantity in notation.inline:
            body = Relation(chain[1][0], chain[0][1], chain[1][1])
            yield f"inline {quantity}", Equation("", formula.line, " ".join(formula.text.split()), body)


def _table_definitions(table: Table, notation: Notation) -> Iterator[Named]:
    for row in table.rows[1:]:
        for cell in row:
            if cell.text.startswith("$") and "=" in cell.text:
                text = cell.text.strip("$")
                chain = parse(tokenize(text, cell.line), notation.functions)
                for body in _pairs(chain):
                    yield table.label, Equation("", table.line, text, body)


def number(cell: Cell) -> Expr:
    """The number in a table's cell as an expression, ``-971.79 + 29.09 i``.

    Raises:
        ReadError: the cell is not mathematics.
    """
    chain = parse(tokenize(cell.text.replace("$", " "), cell.line), {})
    if len(chain) != 1:
        raise ReadError(cell.line, f"expected a number, not {cell.text!r}")
    return chain[0][1]


def _latex(tokens: Sequence[Token], text: str) -> str:
    """The printed text of an equation, without alignment marks, labels and superfluous blanks."""
    printed = text[tokens[0].start_pos : tokens[-1].end_pos]
    if not re.search(r"\\begin", printed):
        printed = re.sub(
            r"(?<!\\)&|\\label\s*\{[^{}]*\}|\\nonumber(?![a-zA-Z])|\\\\(?:\[[^\]]*\])?", " ", printed
        )
    return " ".join(printed.split())
