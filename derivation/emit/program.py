"""The intermediate record: a function of the theory as arguments, locals and outputs, ready for any printer.

`Function`, `Module` and `Package` are what the derivation hands in; `compile_function` turns a `Function`
into a `Program`, which is all that a printer (or an interpreter) ever sees.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from keyword import iskeyword

import sympy

from derivation.emit.lower import EmissionError, Lowering
from derivation.emit.nodes import Call, Name, Node, operations, walk

NAMESPACE = "xp"


@dataclass(frozen=True)
class Argument:
    """A declared argument, spelt `name` in code; `shape` is text for its reader.

    A `parameter` leaves the signature of a function whose formulas do not need it. A `carrier` is a number
    that every caller has: a constant that nothing multiplies takes its type from it.
    """

    name: str
    symbol: sympy.Symbol
    doc: str
    shape: str = "(..., nodes)"
    parameter: bool = False
    carrier: bool = False


@dataclass(frozen=True)
class Function:
    """One function to emit: named outputs, the arguments they may use, the paper's labels they stem from.

    `conjugates` holds pairs (Yc, Y) of symbols: Yc stands for the conjugate of the argument Y. `namespace`
    allows sin, cos, exp, log and sqrt and puts the namespace that has them first among the arguments.
    """

    name: str
    doc: str
    labels: tuple[str, ...]
    arguments: tuple[Argument, ...]
    outputs: tuple[tuple[str, sympy.Expr], ...]
    conjugates: tuple[tuple[sympy.Symbol, sympy.Symbol], ...] = ()
    namespace: bool = False


@dataclass(frozen=True)
class Module:
    name: str
    doc: str
    functions: tuple[Function, ...]


@dataclass(frozen=True)
class Package:
    """The modules of one rod, and the parameters of its own with their defaults, as texts of numbers."""

    model: str
    doc: str
    modules: tuple[Module, ...]
    parameters: tuple[tuple[str, str], ...] = ()


@dataclass(frozen=True)
class Program:
    """Straight-line code in static single assignment: every name is defined once, before its use."""

    name: str
    doc: str
    labels: tuple[str, ...]
    arguments: tuple[Argument, ...]
    namespace: bool
    locals: tuple[tuple[str, Node], ...]
    outputs: tuple[tuple[str, Node], ...]
    operations: tuple[tuple[str, int], ...]


def compile_function(function: Function) -> Program:
    """Common subexpressions become locals; undeclared symbols and inexact arithmetic are refused."""
    used = set[sympy.Symbol]().union(*(expr.free_symbols for _, expr in function.outputs))
    bars = [(bar, field) for bar, field in function.conjugates if bar in used]
    used = used.difference(bar for bar, _ in bars).union(field for _, field in bars)
    _require_declared(function, used)

    spelling = {a.symbol: a.name for a in function.arguments} | {bar: bar.name for bar, _ in bars}
    names = [name for name, _ in function.outputs]

    # In canonical order already, so SymPy need not sort: the same locals whatever the hash seed.
    free = (t for t in sympy.numbered_symbols("t") if t.name not in {*spelling.values(), *names})
    shared, results = sympy.cse([expr for _, expr in function.outputs], symbols=free, order="none", list=True)

    carrier = next((a.name for a in function.arguments if a.carrier), "")
    lowered = Lowering(name=lambda symbol: spelling.get(symbol, symbol.name), carrier=carrier)
    try:
        body: list[tuple[str, Node]] = [
            (bar.name, Call("conjugate", Name(spelling[field]))) for bar, field in bars
        ]
        body += [(symbol.name, lowered(expr)) for symbol, expr in shared]
        outputs = [(name, lowered(expr)) for name, expr in zip(names, results, strict=True)]
    except EmissionError as error:
        raise EmissionError(f"{function.name}: {error}") from None
    nodes = [node for _, node in body + outputs]
    require_namespace(function, nodes)
    occurring = {part.text for node in nodes for part in walk(node) if isinstance(part, Name)}
    arguments = tuple(a for a in function.arguments if not a.parameter or a.name in occurring)
    require_names(
        function.name, [NAMESPACE, *(a.name for a in arguments), *(bar.name for bar, _ in bars), *names]
    )
    return Program(
        function.name,
        function.doc,
        function.labels,
        arguments,
        function.namespace,
        tuple(body),
        tuple(outputs),
        tuple((kind, number) for kind, number in operations(nodes).items() if number),
    )


def _require_declared(function: Function, used: set[sympy.Symbol]) -> None:
    declared = {a.symbol for a in function.arguments}
    if missing := sorted(symbol.name for symbol in used - declared):
        allowed = ", ".join(a.name for a in function.arguments) or "none"
        raise EmissionError(f"{function.name}: {', '.join(missing)} not among its arguments ({allowed})")


def require_names(where: str, names: Iterable[str]) -> None:
    """Names become code, so they must be identifiers; each is defined once."""
    seen: set[str] = set()
    for name in names:
        if not name.isidentifier() or iskeyword(name):
            raise EmissionError(f"{where}: {name!r} is not a name that code can use")
        if name in seen:
            raise EmissionError(f"{where}: the name {name!r} is defined twice")
        seen.add(name)


def require_namespace(function: Function, nodes: Iterable[Node]) -> None:
    parts = (part for node in nodes for part in walk(node))
    calls = {part.function for part in parts if isinstance(part, Call)} - {"conjugate"}
    if calls and not function.namespace:
        raise EmissionError(f"{function.name}: {', '.join(sorted(calls))} needs namespace=True")
