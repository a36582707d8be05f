"""Derived objects for readers: any record, equation or expression as plain text, LaTeX or Python."""

from __future__ import annotations

import textwrap
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import fields, is_dataclass
from typing import Any, Literal

import sympy

from derivation.emit.lower import Lowering
from derivation.emit.nodes import Name, Node
from derivation.emit.printers import python
from derivation.emit.printers.notation import LATEX, PYTHON, TEXT, Notation, expression, rows

Format = Literal["text", "latex", "python"]
FORMATS: tuple[Format, ...] = ("text", "latex", "python")
NOTATIONS: Mapping[Format, Notation] = {"text": TEXT, "latex": LATEX, "python": PYTHON}
WIDTH = 100


def show(
    name: str, value: Any, form: Format = "text", letters: Mapping[sympy.Symbol, str] | None = None
) -> str:
    """The object as equations `name = …`, one below the other.

    `value` is a SymPy expression or equation, an element of a polynomial ring, or a frozen record, mapping or
    sequence of such. `letters` gives the paper's LaTeX of symbols; what is not in it is spelt by SymPy.
    Raises ValueError for a format that is not one of `FORMATS`.
    """
    if form not in FORMATS:
        raise ValueError(f"unknown format {form!r}: choose one of {', '.join(FORMATS)}")
    letters = letters or {}
    lowered = Lowering(name=_spelling(form, letters), opaque=_foreign(form, letters), exact=False)
    equations = [_equation(key, part, form, lowered) for key, part in _parts(name, value)]
    if form != "latex" or len(equations) == 1:
        return "\n".join(equations)
    return "\\begin{gathered}\n" + " \\\\\n".join(equations) + "\n\\end{gathered}"


def _parts(name: str, value: Any) -> Iterator[tuple[str, Any]]:
    """The leaves of a record with the names that lead to them."""
    if hasattr(value, "as_expr"):  # an element of a ring is also a mapping
        value = value.as_expr()
    if is_dataclass(value):
        members = [(f.name, getattr(value, f.name)) for f in fields(value)]
    elif isinstance(value, Mapping):
        members = list(value.items())
    elif isinstance(value, sympy.MatrixBase):
        rows, columns = value.shape
        members = [(f"{i + 1}{j + 1}", value[i, j]) for i in range(rows) for j in range(columns)]
    elif isinstance(value, Sequence) and not isinstance(value, str):
        members = [(str(i), part) for i, part in enumerate(value, start=1)]
    else:
        yield name, value
        return
    for key, part in members:
        yield from _parts(f"{name}.{key}", part)


def _equation(name: str, value: Any, form: Format, lowered: Lowering) -> str:
    if isinstance(value, sympy.Eq):
        head, value = expression(lowered(value.lhs), NOTATIONS[form]), value.rhs
        head = f"{name}: {head}" if form == "text" else head
    else:
        head = lowered.name(sympy.Symbol(name))
    if not isinstance(value, sympy.Expr):
        return f"{name}: {value}"
    node = lowered(value)
    if form == "python":
        return textwrap.dedent(python.statement(f"{head} = ", node))
    lines = rows(node, NOTATIONS[form], WIDTH - len(head))
    if form == "text":
        return f"{head} = " + f"\n{' ' * len(head)} ".join(lines)
    if len(lines) == 1:
        return f"{head} = {lines[0]}"
    return f"\\begin{{aligned}}\n{head} ={{}}& " + " \\\\\n&".join(lines) + "\n\\end{aligned}"


def _spelling(form: Format, letters: Mapping[sympy.Symbol, str]) -> Callable[[sympy.Symbol], str]:
    if form == "latex":
        return lambda symbol: letters.get(symbol) or str(sympy.latex(symbol))
    return lambda symbol: str(symbol.name)


def _foreign(form: Format, letters: Mapping[sympy.Symbol, str]) -> Callable[[sympy.Basic], Node]:
    """Constants, derivatives, integrals: SymPy spells them."""
    if form == "latex":
        return lambda expr: Name(sympy.latex(expr, symbol_names=dict(letters)))
    return lambda expr: Name(sympy.sstr(expr))
