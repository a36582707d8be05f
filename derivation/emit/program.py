"""The intermediate record: a function of the theory as arguments, locals and outputs, ready for any printer.

`Function`, `Module` and `Package` are what the derivation hands in; `compile_function` turns a `Function` into a `Program`,
which is all that a printer (or an interpreter) ever sees.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from itertools import chain
from keyword import iskeyword

import sympy

from derivation.emit.lower import EmissionError, Lowering
from derivation.emit.nodes import Call, Name, Node, operations, walk

NAMESPACE = "xp"
NODES = "(..., nodes)"


@dataclass(frozen=True)
class Argument:
    """A declared argument. A `parameter` leaves the signature of every function whose formulas do not need it."""

    name: str
    symbol: sympy.Symbol
    doc: str
    shape: str = NODES
    parameter: bool = False


@dataclass(frozen=True)
class Function:
    """One function to emit. `conjugates` holds pairs (Yc, Y) of symbols: Yc stands for the conjugate of argument Y."""

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
    """The modules of one rod."""

    model: str
    doc: str
    modules: tuple[Module, ...]


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
    """Common subexpressions become locals; refuses undeclared symbols and arithmetic that is not exact everywhere."""
    used = set().union(*(expr.free_symbols for _, expr in function.outputs))
    conjugates = [(bar, field) for bar, field in function.conjugates if bar in used]
    used = (used - {bar for bar, _ in conjugates}) | {field for _, field in conjugates}
    arguments = tuple(a for a in function.arguments if not a.parameter or a.symbol in used)
    _require_declared(function, used)

    spelling = {a.symbol: a.name for a in arguments} | {bar: bar.name for bar, _ in conjugates}
    outputs = [name for name, _ in function.outputs]
    _require_names(function.name, [NAMESPACE, *spelling.values(), *outputs])
    shared, expressions = _common_subexpressions([expr for _, expr in function.outputs], {*spelling.values(), *outputs})
    lowered = Lowering(name=lambda symbol: spelling.get(symbol, symbol.name))
    try:
        bodies = [(symbol.name, lowered(expr)) for symbol, expr in shared]
        results = tuple(zip(outputs, map(lowered, expressions), strict=True))
    except EmissionError as error:
        raise EmissionError(f"{function.name}: {error}") from None
    bars = [(bar.name, Call("conjugate", Name(spelling[field]))) for bar, field in conjugates]
    body = (*bars, *bodies)
    count = operations(node for _, node in chain(body, results))
    _require_namespace(function, (node for _, node in chain(body, results)))
    return Program(
        function.name, function.doc, function.labels, arguments, function.namespace, body, results, tuple((kind, number) for kind, number in count.items() if number)
    )


def _common_subexpressions(
    expressions: list[sympy.Expr], taken: set[str]
) -> tuple[list[tuple[sympy.Symbol, sympy.Expr]], list[sympy.Expr]]:
    """SymPy's elimination without its own sorting: its input is already in canonical order, whatever the hash seed."""
    names = (symbol for symbol in sympy.numbered_symbols("t") if symbol.name not in taken)
    shared, reduced = sympy.cse(expressions, symbols=names, order="none", list=True)
    return shared, reduced


def _require_declared(function: Function, used: set[sympy.Symbol]) -> None:
    declared = {a.symbol for a in function.arguments}
    if missing := sorted(symbol.name for symbol in used - declared):
        allowed = ", ".join(a.name for a in function.arguments) or "none"
        raise EmissionError(
            f"{function.name}: {', '.join(missing)} occurs in its formulas and is no argument (declared: {allowed})"
        )


def _require_names(where: str, names: Iterable[str]) -> None:
    """Names become code, so they must be identifiers; each is defined once."""
    seen: set[str] = set()
    for name in names:
        if not name.isidentifier() or iskeyword(name):
            raise EmissionError(f"{where}: {name!r} is not a name that code can use")
        if name in seen:
            raise EmissionError(f"{where}: the name {name!r} is defined twice")
        seen.add(name)


def _require_namespace(function: Function, nodes: Iterable[Node]) -> None:
    calls = {n.function for root in nodes for n in walk(root) if isinstance(n, Call) and n.function != "conjugate"}
    if calls and not function.namespace:
        raise EmissionError(f"{function.name}: {', '.join(sorted(calls))} needs namespace=True")
