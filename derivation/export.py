"""What leaves for the other tools of the field: formats by name, each a function of the derivation."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from functools import partial

from derivation.criticalmode import critical_mode_problem
from derivation.emit.printers import auto
from derivation.emit.printers.auto import Start
from derivation.emit.printers.document import document
from derivation.emit.printers.language import JAX, JULIA, MATHEMATICA, C, Language, source
from derivation.modules import package
from derivation.pipeline import Derivation


def _functions(language: Language, d: Derivation) -> str:
    return source(package(d), language)


#: The formats that need nothing but the rod's derivation.
FORMATS: Mapping[str, Callable[[Derivation], str]] = {
    "latex": document,
    "mathematica": partial(_functions, MATHEMATICA),
    "julia": partial(_functions, JULIA),
    "c": partial(_functions, C),
    "jax": partial(_functions, JAX),
}


def auto_equations(
    d: Derivation, title: str, parameters: Mapping[str, float], table: Sequence[Sequence[float]]
) -> str:
    """The problem of the critical mode for AUTO-07p, from the solution in the table on; see `Start`."""
    start = Start(
        title, {name: repr(value) for name, value in parameters.items()}, [[*map(repr, row)] for row in table]
    )
    return auto.source(critical_mode_problem(package(d)), d.model.name, start)
