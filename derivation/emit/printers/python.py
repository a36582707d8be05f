"""Programs as Python source: plain arithmetic that runs on every number type."""

from __future__ import annotations

import textwrap
from collections.abc import Iterable
from functools import cache
from importlib.resources import files
from string import Template

from derivation.emit.lower import EmissionError
from derivation.emit.nodes import Node
from derivation.emit.printers.notation import PYTHON, expression
from derivation.emit.program import NAMESPACE, Module, Program, compile_function

WIDTH = 110
INDENT = " " * 4


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
        doc=docstring(program.doc),
        facts="\n".join(_facts(program)),
        body="\n".join(body),
    )


def statement(prefix: str, node: Node) -> str:
    """One statement; a long one is put in brackets and broken before its plus and minus signs."""
    text = expression(node, PYTHON)
    if len(line := INDENT + prefix + text) <= WIDTH:
        return line
    glued = text.replace(" + ", " +\xa0").replace(" - ", " -\xa0")
    lines = _wrapped(glued, INDENT * 2)
    return "\n".join([f"{INDENT}{prefix}(", *(line.replace("\xa0", " ") for line in lines), f"{INDENT})"])


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
