"""A boundary-value problem as an equations file of AUTO-07p, in C: func, bcnd, stpnt.

The file begins with the constants file that goes with it, in a comment.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from fractions import Fraction

from derivation.criticalmode import BoundaryValueProblem
from derivation.emit.nodes import Name, walk
from derivation.emit.printers.language import C, Language, words
from derivation.emit.printers.layout import INDENT, statement, wrapped
from derivation.emit.printers.notation import SUM
from derivation.emit.printers.python import template
from derivation.emit.program import Program, compile_function

_REAL = "doublereal"
_CONTINUED = "k2"  # any other parameter will do as well
#: Steps of the continuation and its end, in units of the parameter at the start.
_STEPS = {"least": Fraction(1, 10**7), "step": Fraction(1, 10**3), "longest": Fraction(1, 10), "most": 10}
#: As in C, besides the names that AUTO gives to the arguments of its functions.
AUTO: Language = replace(
    C,
    name="auto",
    notation=replace(C.notation, power=("pow({}, {})", SUM)),
    reserved=C.reserved
    | words("ndim u icp par ijac f dfdu dfdp nbc u0 u1 fb dbc t doublereal integer pow NODES SHAPES"),
)


@dataclass(frozen=True)
class Start:
    """A solution to start from, as texts of numbers.

    parameters: by name, all of the problem's. table: one row a node: its place, its barycentric weight, then
    the states of the problem there, a further coordinate left out.
    """

    title: str
    parameters: Mapping[str, str]
    table: Sequence[Sequence[str]]


def source(problem: BoundaryValueProblem, model: str, start: Start) -> str:
    """The text of the equations file.

    Raises EmissionError where a parameter's name means something else in C or in AUTO.
    """
    names = [a.name for a in problem.parameters]
    states, conditions = problem.states, problem.conditions.outputs
    given = [f"{INDENT}par[{i}] = {start.parameters[name]};" for i, name in enumerate(names)]
    shapes, size = len(start.table[0]) - 2, float(start.parameters[_CONTINUED])
    listed = [
        f"{i} {name} ({a.doc})" for i, (name, a) in enumerate(zip(names, problem.parameters, strict=True), 1)
    ]
    return template("auto_file").substitute(
        model=model,
        start=AUTO.text(start.title),
        parameters="\n".join(line for text in listed for line in wrapped(AUTO.text(text), INDENT)),
        unames=_dictionary(states),
        parnames=_dictionary(names),
        ndim=len(states),
        nbc=len(conditions),
        free=", ".join(repr(name) for name in (_CONTINUED, *problem.unknowns)),
        continued=_CONTINUED,
        **{name: f"{size * float(scale):g}" for name, scale in _STEPS.items()},
        rates="\n".join(_body(compile_function(problem.rates), names, {"u": states}, "f")),
        conditions="\n".join(
            _body(
                compile_function(problem.conditions),
                names,
                {"u0": [f"{s}_clamp" for s in states], "u1": [f"{s}_tip" for s in states]},
                "fb",
            )
        ),
        given="\n".join(given),
        nodes=len(start.table),
        shapes=shapes,
        table=",\n".join(f"{INDENT}{{{', '.join(row)}}}" for row in start.table),
        rest="\n".join(f"{INDENT}u[{i}] = t;" for i in range(shapes, len(states))),
    )


def _dictionary(names: Sequence[str]) -> str:
    return "{" + ", ".join(f"{i}: {name!r}" for i, name in enumerate(names, start=1)) + "}"


def _body(
    program: Program, parameters: Sequence[str], states: Mapping[str, Sequence[str]], result: str
) -> Iterable[str]:
    """Names for the entries of AUTO's arrays, as far as they are used, then the formulas."""
    arrays = {**states, "par": parameters}
    places = {name: f"{array}[{i}]" for array, names in arrays.items() for i, name in enumerate(names)}
    nodes = [node for _, node in (*program.locals, *program.outputs)]
    used = {part.text for node in nodes for part in walk(node) if isinstance(part, Name)}
    for name in (a.name for a in program.arguments if a.name in used):
        yield f"{INDENT}const {_REAL} {AUTO.spell(name)} = {places[name]};"
    for name, node in program.locals:
        yield statement(f"const {_REAL} {AUTO.spell(name)} = ", node, AUTO.notation, ";")
    for i, (_, node) in enumerate(program.outputs):
        yield statement(f"{result}[{i}] = ", node, AUTO.notation, ";")
