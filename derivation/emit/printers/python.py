"""Programs as Python source: plain arithmetic that runs on every number type."""

from __future__ import annotations

import textwrap
from collections.abc import Iterable
from functools import cache
from importlib.resources import files
from itertools import pairwise
from string import Template

from derivation.emit.lower import EmissionError
from derivation.emit.nodes import Node
from derivation.emit.printers.notation import PYTHON, expression, rows
from derivation.emit.program import NAMESPACE, Module, Program, compile_function

WIDTH = 110
INDENT = " " * 4
GLUE = "\xa0"


@cache
def template(name: str) -> Template:
    return Template(files("derivation.emit").joinpath("templates", f"{name}.txt").read_text(encoding="utf-8"))


def module(source: Module, model: str) -> str:
    """The text of one module."""
    functions = [function(compile_function(f)) for f in source.functions]
    head = template("module").substitute(header=header(model), doc=docstring(source.doc))
    return "\n\n".join([head, *functions])


def header(model: str) -> str:
    return template("header").substitute(model=model).rstrip("\n")


def function(program: Program) -> str:
    """The text of one function."""
    arguments = [NAMESPACE] * program.namespace + [a.name for a in program.arguments]
    body = [statement(f"{name} = ", node) for name, node in program.locals]
    if len(program.outputs) == 1:
        body.append(statement("return ", program.outputs[0][1]))
    else:
        body += [statement(f"{name} = ", node) for name, node in program.outputs]
        body.append(f"{INDENT}return {', '.join(name for name, _ in program.outputs)}")
    return template("function").substitute(
        name=program.name,
        arguments=", ".join(arguments),
        doc="\n".join(_wrapped('"""' + docstring(program.doc), INDENT)),
        facts="\n".join(_facts(program)),
        body="\n".join(body),
    )


def statement(prefix: str, node: Node) -> str:
    """One statement; a long one is put in brackets and broken between its terms, a long term inside too."""
    if len(line := INDENT + prefix + expression(node, PYTHON)) <= WIDTH:
        return line
    lines = [line for row in rows(node, PYTHON, WIDTH - 2 * len(INDENT)) for line in _broken(row)]
    return "\n".join([f"{INDENT}{prefix}(", *lines, f"{INDENT})"])


def _broken(row: str) -> list[str]:
    """A row on several lines if it needs them, broken before signs inside as few brackets as possible."""
    for depth in range(row.count("(") + 1):
        lines = _wrapped(_glued(row, depth), INDENT * 2, hanging=INDENT)
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


def docstring(text: str) -> str:
    """The text made fit to stand between triple quotes."""
    if '"""' in text or "\\" in text:
        raise EmissionError(f"a docstring cannot hold a backslash or triple quotes: {text!r}")
    return text


def _facts(program: Program) -> Iterable[str]:
    """The docstring below its first line: arguments, result, source, cost."""
    if program.namespace:
        yield f"{INDENT}{NAMESPACE}: the namespace of the functions, such as numpy or mpmath.mp"
    for a in program.arguments:
        yield from _wrapped(docstring(f"{a.name} {a.shape}: {a.doc}"), INDENT, hanging=INDENT)
    yield from _wrapped("Returns " + ", ".join(name for name, _ in program.outputs) + ".", INDENT)
    if program.labels:
        yield from _wrapped("Paper: " + ", ".join(map(docstring, program.labels)) + ".", INDENT)
    count = ", ".join(f"{number} {kind[:-1] if number == 1 else kind}" for kind, number in program.operations)
    yield from _wrapped(f"Operations: {count or 'none'}.", INDENT)


def _wrapped(text: str, indent: str, hanging: str = "") -> list[str]:
    return textwrap.wrap(
        text,
        WIDTH,
        initial_indent=indent,
        subsequent_indent=indent + hanging,
        break_long_words=False,
        break_on_hyphens=False,
    )
