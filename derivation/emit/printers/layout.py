"""Lines of a fixed width: statements broken between terms, texts wrapped."""

from __future__ import annotations

import textwrap
from itertools import pairwise

from derivation.emit.nodes import Node
from derivation.emit.printers.notation import Notation, expression, rows

WIDTH = 110
INDENT = " " * 4
GLUE = "\xa0"


def statement(prefix: str, node: Node, notation: Notation, end: str = "") -> str:
    """One statement; a long one is put in brackets and broken between its terms, a long term inside too."""
    if len(line := INDENT + prefix + expression(node, notation) + end) <= WIDTH:
        return line
    lines = [line for row in rows(node, notation, WIDTH - 2 * len(INDENT)) for line in _broken(row)]
    return "\n".join([f"{INDENT}{prefix}(", *lines, f"{INDENT}){end}"])


def _broken(row: str) -> list[str]:
    """A row on several lines if it needs them, broken before signs inside as few brackets as possible."""
    for depth in range(row.count("(") + 1):
        lines = wrapped(_glued(row, depth), INDENT * 2, hanging=INDENT)
        if max(map(len, lines)) <= WIDTH:
            break
    return [line.replace(GLUE, " ") for line in lines]


def _glued(row: str, depth: int) -> str:
    """Only spaces before a sign inside at most so many brackets remain spaces, where a line may end."""
    text, inside = "", 0
    for before, char in pairwise(" " + row):
        inside += (char == "(") - (char == ")")
        text += GLUE if char == " " and (before in "+-" or inside > depth) else char
    return text


def wrapped(text: str, indent: str, hanging: str = "") -> list[str]:
    """The text on lines of the width, the first indented, the others by `hanging` more."""
    return textwrap.wrap(
        text,
        WIDTH,
        initial_indent=indent,
        subsequent_indent=indent + hanging,
        break_long_words=False,
        break_on_hyphens=False,
    )
