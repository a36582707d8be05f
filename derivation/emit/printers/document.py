"""All derived objects of a rod as one LaTeX document, in the paper's letters and the derivation's order."""

from __future__ import annotations

from collections.abc import Iterable
from itertools import groupby

from sympy import Basic, Eq, Expr, Integral, Tuple, latex

from derivation.catalogue import Object, objects
from derivation.emit.lower import EmissionError, Lowering
from derivation.emit.nodes import Name, Node
from derivation.emit.printers.notation import LATEX, expression, rows
from derivation.emit.printers.python import template
from derivation.pipeline import Derivation
from derivation.symbols import latex_names

WIDTH = 100


def document(d: Derivation) -> str:
    """The text of the document, for any LaTeX with amsmath."""
    known = list(objects(d).values())
    return template("latex_file").substitute(
        model=d.model.name.replace("_", r"\_"),
        title=_prose(d.model.title),
        sections="\n".join(_section(stage, group) for stage, group in groupby(known, lambda o: o.stage)),
    )


def _section(stage: str, group: Iterable[Object]) -> str:
    return "\n".join([f"\\section{{{stage.capitalize()}}}", *map(_object, group)])


def _object(o: Object) -> str:
    """A title and the equations; the first bears the object's name as its label, behind `rod:`."""
    paper = rf" (\texttt{{{_prose(o.label)}}})" if o.label else ""
    head = rf"\paragraph{{{_prose(o.title[0].upper() + o.title[1:])}.}} \texttt{{{_prose(o.name)}}}{paper}"
    labels = [f"\\label{{rod:{o.name}}}", *[""] * (len(o.equations) - 1)]
    lines = [_equation(e, label) for e, label in zip(o.equations, labels, strict=True)]
    return "\n".join([head, r"\begin{align}", " \\\\\n".join(lines), r"\end{align}"])


def _equation(equation: Eq, label: str) -> str:
    """An equation, numbered once, on as many lines as it needs."""
    left = expression(_lowered(equation.lhs), LATEX)
    first, *others = rows(_lowered(equation.rhs), LATEX, WIDTH)
    lines = [f"{left} &= {first}", *(rf"&\quad {line}" for line in others)]
    return " \\notag \\\\\n".join(lines) + label


def _lowered(expr: Expr) -> Node:
    letters = latex_names()
    return Lowering(name=lambda s: letters.get(s) or latex(s), opaque=_integral, exact=False)(expr)


def _integral(expr: Basic) -> Node:
    """The only thing in an equation that is no arithmetic."""
    match expr:
        case Integral(args=(integrand, Tuple(args=(u, start, end)))):
            return Name(
                rf"\int_{start}^{end} \mathrm{{d}}{u}\,\left({expression(_lowered(integrand), LATEX)}\right)"
            )
    raise EmissionError(f"no LaTeX for {expr}")


def _prose(text: str) -> str:
    """Words of the catalogue, which hold no commands, with LaTeX's own characters made harmless."""
    for old, new in _ESCAPES:
        text = text.replace(old, new)
    return text


_ESCAPES = (
    ("\\", "/"),
    *((c, f"\\{c}") for c in "{}$&#%_"),
    ("^", r"\^{}"),
    ("~", r"\~{}"),
)
