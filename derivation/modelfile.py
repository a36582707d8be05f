"""A rod as a text file: TOML with formulas, read into a RodModel. docs/your-rod.md describes the format.

Formulas are read by :mod:`derivation.formula`; nothing in the file is ever evaluated as code.
"""

from __future__ import annotations

import re
import tomllib
from keyword import iskeyword
from typing import Any

from sympy import Expr, Integer
from sympy import cos as cosine
from sympy import sin as sine

from derivation.errors import ModelError, ReadError
from derivation.formula import FormulaError, read_formula
from derivation.model import Parameter, RodModel, Triple
from derivation.symbols import AMPLITUDE, PARAMETERS, QUANTITIES, SHAPES, STRAIGHT, parameter, symbol

BASIC = ("k1", "k2", "gamma1", "gamma3")
STRAINS = ("h1", "h2", "Pi")
VELOCITIES = ("v1", "v2", "Omega")
STRESSES = ("F1", "F2", "M")
LONGEST_NAME = 30

#: kind of load -> what it takes; all but a share must be given.
LOADS: dict[str, tuple[str, ...]] = {
    "follower": ("share",),
    "dead": ("share",),
    "distributed": ("share",),
    "spring": ("stiffness",),
    "damper": ("drag",),
    "drag": ("axial", "transverse"),
}


def read_model(text: str) -> RodModel:
    """The rod that a file describes.

    Raises:
        ReadError: for a formula that cannot be read; the message gives line and column and what was expected.
        ModelError: for anything else that is missing, unknown or contradictory.
    """
    try:
        table = tomllib.loads(text)
    except (tomllib.TOMLDecodeError, RecursionError) as error:
        raise ModelError(f"not TOML: {error}") from None
    return _File(text, table).model()


class _File:
    """The tables of one file, with its text to say where something stands."""

    def __init__(self, text: str, table: dict[str, Any]) -> None:
        self._text, self._table = text, table

    def model(self) -> RodModel:
        _require_keys(
            "the file", self._table, ("name", "title", "parameters", "energy", "drag", "tip", "load")
        )
        name = _identifier("name", self._required("name"))
        title = self._table.get("title", f"planar Cosserat rod {name}")
        if not isinstance(title, str) or not title or len(title) > 100 or not title.isprintable():
            raise ModelError("title must be one line of at most 100 characters")
        if {'"', "\\"} & set(title):
            raise ModelError("title must not hold quotes or backslashes")
        own = self._parameters()
        known = (*BASIC, *(p.name for p in own))
        energy = self._formula("energy", self._required("energy"), (*STRAINS, *known))
        drag = self._components("drag", VELOCITIES, (*STRAINS, *known))
        moving: Triple = tuple(c * symbol(v) for c, v in zip(drag, VELOCITIES, strict=True))
        tip, body = self._loads(known)
        return RodModel(name, title, energy, moving, tip, body, own)

    def _parameters(self) -> tuple[Parameter, ...]:
        found = []
        for name, entry in _table("parameters", self._table.get("parameters", {})).items():
            _identifier("parameter", name)
            if name in _RESERVED or _DERIVED.fullmatch(name):
                raise ModelError(f"parameter {name!r}: the name has a meaning already; take another")
            entry = _table(f"parameter {name!r}", entry)
            _require_keys(f"parameter {name!r}", entry, ("default", "meaning"))
            if "default" not in entry:
                raise ModelError(f"parameter {name!r} needs a default, the text of a number")
            value = self._formula(f"default of {name!r}", entry["default"], ())
            if not value.is_Rational:
                raise ModelError(
                    f"parameter {name!r}: the default is {value}, but it must be a rational number"
                )
            meaning = entry.get("meaning", name)
            if not isinstance(meaning, str) or len(meaning) > 100 or not meaning.isprintable():
                raise ModelError(f"parameter {name!r}: meaning must be one line of at most 100 characters")
            if {'"', "\\"} & set(meaning):
                raise ModelError(f"parameter {name!r}: meaning must not hold quotes or backslashes")
            parameter(name)
            found.append(Parameter(name, meaning, str(value)))
        return tuple(found)

    def _loads(self, known: tuple[str, ...]) -> tuple[Triple, Triple]:
        """Loads at the tip and along the rod: by kind, or as formulas for the stresses at the tip."""
        if ("tip" in self._table) == ("load" in self._table):
            raise ModelError("the rod needs either [[load]] entries or one [tip] table, and not both")
        if "tip" in self._table:
            return self._components("tip", STRESSES, ("theta", *VELOCITIES, "force", *known)), _NONE
        entries = self._table["load"]
        if not isinstance(entries, list) or not entries:
            raise ModelError("load must be a list: write [[load]] before each")
        tip, body = [Integer(0)] * 3, [Integer(0)] * 3
        for number, entry in enumerate(entries, 1):
            where = f"load {number}"
            entry = dict(_table(where, entry))
            kind = entry.pop("kind", None)
            if kind not in LOADS:
                raise ModelError(f"{where}: kind is {kind!r}; it must be one of {', '.join(LOADS)}")
            _require_keys(f"{where} ({kind})", entry, LOADS[kind])
            defaults = {"share": "1"} if "share" in LOADS[kind] else {}
            given = defaults | entry
            if missing := [key for key in LOADS[kind] if key not in given]:
                raise ModelError(f"{where} ({kind}) needs {', '.join(missing)}")
            values = [self._formula(f"{key} of {where}", given[key], known) for key in LOADS[kind]]
            target = body if kind == "distributed" else tip
            for k, part in enumerate(_stresses(kind, values)):
                target[k] += part
        return (tip[0], tip[1], tip[2]), (body[0], body[1], body[2])

    def _components(self, table: str, components: tuple[str, ...], names: tuple[str, ...]) -> Triple:
        entries = _table(table, self._required(table))
        _require_keys(f"[{table}]", entries, components)
        if missing := [c for c in components if c not in entries]:
            raise ModelError(f"[{table}] needs {', '.join(missing)}")
        a, b, c = (self._formula(f"{q} of [{table}]", entries[q], names) for q in components)
        return a, b, c

    def _required(self, key: str) -> Any:
        if key not in self._table:
            raise ModelError(f"{key} is missing")
        return self._table[key]

    def _formula(self, where: str, value: Any, names: tuple[str, ...]) -> Expr:
        if isinstance(value, bool) or not isinstance(value, str | int | float):
            raise ModelError(f"{where} must be a formula in quotes")
        text = str(value)
        try:
            return read_formula(text, names)
        except FormulaError as error:
            at = self._text.find(text) if isinstance(value, str) and text.strip() else -1
            if at < 0:  # empty, a number, or spelt with escapes: its place in the file is not known
                raise ModelError(f"{where}: {error}") from None
            before = self._text[:at]
            line, column = before.count("\n") + error.line, error.column
            if error.line == 1:
                column += at - (before.rfind("\n") + 1)
            raise ReadError(line, f"column {column}: {where}: {error}") from None


_NONE: Triple = (Integer(0), Integer(0), Integer(0))
_RESERVED = {
    *(*BASIC, *STRAINS, *VELOCITIES, *STRESSES, "force", "theta", "xp", "x", "y", "c"),
    *(*PARAMETERS, *QUANTITIES, *AMPLITUDE, *SHAPES, *STRAIGHT, "exp", "log", "sqrt"),
    *("length", "k3", "gamma2", "model", "scales", "L", "stretch", "sign", "slope", "tension", "forcing"),
    *("shear", "compression", "balance", "along_v1", "along_v2", "along_Omega", "g1", "g2", "g3", "g4"),
}

#: Names that the derivation makes: derivatives, values at the ends, responses, coefficients, inverses.
_DERIVED = re.compile(
    r"(x|y|theta)(_.*|\d.*)|(X|Y|H|Theta|Psi|P0|P2|X0|X2|A)_.*|(X|Y|Theta|c)\d{3}|(W|C\d|L\d)_\d+|"
    r".*_(inv|bar|tip|clamp)|place"
)


def _stresses(kind: str, values: list[Expr]) -> Triple:
    """What one load adds to (F1, F2, M) at the tip, or to the force per length along the rod."""
    force, theta = symbol("force"), symbol("theta")
    none = Integer(0)
    match kind, values:
        case "follower" | "distributed", [share]:
            return -share * force, none, none
        case "dead", [share]:
            return -share * force * cosine(theta), share * force * sine(theta), none
        case "spring", [stiffness]:
            return none, none, -stiffness * theta
        case "damper", [drag]:
            return none, none, -drag * symbol("Omega")
        case "drag", [axial, transverse]:
            return -axial * symbol("v1"), -transverse * symbol("v2"), none
    raise AssertionError(kind)


def _table(where: str, value: Any) -> dict[str, Any]:
    if not isinstance(value, dict):
        raise ModelError(f"{where} must be a table")
    return value


def _require_keys(where: str, entries: dict[str, Any], allowed: tuple[str, ...]) -> None:
    if strange := [key for key in entries if key not in allowed]:
        raise ModelError(f"{where} has an unknown {strange[0][:40]!r}; it may hold {', '.join(allowed)}")


def _identifier(what: str, name: Any) -> str:
    if isinstance(name, str) and iskeyword(name):
        raise ModelError(f"{what} is {name!r}, a word that Python reserves; take another")
    if not isinstance(name, str) or not name.isascii() or not name.isidentifier():
        raise ModelError(f"{what} is {str(name)[:40]!r}, but it must be a name of letters, digits and _")
    if len(name) > LONGEST_NAME or name.startswith("_") or "__" in name:
        raise ModelError(
            f"{what} {name[:40]!r} must have at most {LONGEST_NAME} characters, no __, and not begin with _"
        )
    return name
