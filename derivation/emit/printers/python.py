"""Programs as Python source: plain arithmetic that runs on every number type."""

from __future__ import annotations

from collections.abc import Iterable
from functools import cache
from importlib.resources import files
from string import Template

from derivation.emit.lower import EmissionError
from derivation.emit.nodes import Node
from derivation.emit.printers import layout
from derivation.emit.printers.layout import INDENT, wrapped
from derivation.emit.printers.layout import WIDTH as WIDTH
from derivation.emit.printers.notation import PYTHON
from derivation.emit.program import NAMESPACE, Module, Program, compile_function


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
        doc="\n".join(wrapped('"""' + docstring(program.doc), INDENT)),
        facts="\n".join(facts(program)),
        body="\n".join(body),
    )


def statement(prefix: str, node: Node) -> str:
    """One statement, on as many lines as it needs."""
    return layout.statement(prefix, node, PYTHON)


def docstring(text: str) -> str:
    """The text made fit to stand between triple quotes."""
    if '"""' in text or "\\" in text:
        raise EmissionError(f"a docstring cannot hold a backslash or triple quotes: {text!r}")
    return text


def facts(program: Program) -> Iterable[str]:
    """The docstring below its first line: arguments, result, source, cost."""
    if program.namespace:
        yield f"{INDENT}{NAMESPACE}: the namespace of the functions, such as numpy or mpmath.mp"
    for a in program.arguments:
        yield from wrapped(docstring(f"{a.name} {a.shape}: {a.doc}"), INDENT, hanging=INDENT)
    yield from wrapped("Returns " + ", ".join(name for name, _ in program.outputs) + ".", INDENT)
    if program.labels:
        yield from wrapped("Paper: " + ", ".join(map(docstring, program.labels)) + ".", INDENT)
    count = ", ".join(f"{number} {kind[:-1] if number == 1 else kind}" for kind, number in program.operations)
    yield from wrapped(f"Operations: {count or 'none'}.", INDENT)
