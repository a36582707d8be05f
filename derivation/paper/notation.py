"""Which letter of a paper stands for which quantity: data, read from a TOML file.

Sections: ``[symbols]`` maps a letter (as LaTeX, in any spelling) to a quantity of the theory;
``[functions]`` maps a letter to the names of its arguments, which decides whether ``f(u)`` is a value or a
product; ``[inline]`` lists the quantities whose definitions stand in running text.
"""

from __future__ import annotations

import tomllib
from dataclasses import dataclass
from difflib import get_close_matches
from functools import cache
from pathlib import Path

from derivation.errors import ReadError

DEFAULT = Path(__file__).with_name("notation.toml")
SECTIONS = {"symbols", "functions", "inline"}
#: Names of constants that the ledger makes itself.
MADE = {"L", "omega_branch", "step", "R_T", "phase_T", "lambda_F", "lambda_FF", "lambda_FFF"} | {
    f"{name}_{part}" for name in ("alpha", "beta") for part in ("re", "im")
}


@dataclass(frozen=True)
class Notation:
    """A paper's letters.

    Attributes:
        symbols: letter (one spelling) -> quantity.
        functions: letter -> names of its arguments.
        inline: quantities whose definitions are looked for in running text.
    """

    symbols: dict[str, str]
    functions: dict[str, tuple[str, ...]]
    inline: tuple[str, ...]

    def quantity(self, letter: str) -> str | None:
        """What ``letter`` stands for, None when the notation does not say."""
        return self.symbols.get(letter)


@cache
def load(path: Path = DEFAULT) -> Notation:
    """Read a notation.

    Raises:
        ReadError: not TOML in UTF-8, an unknown section, an entry of another kind than expected.
        OSError: the file cannot be read.
    """
    from derivation.paper.parse import letter_name

    try:
        text = path.read_text(encoding="utf-8")
        data = tomllib.loads(text)
    except UnicodeDecodeError:
        raise ReadError(1, f"{path.name} is not a text in UTF-8") from None
    except RecursionError:
        raise ReadError(1, f"{path.name}: lists nested too deeply") from None
    except tomllib.TOMLDecodeError as error:
        raise ReadError(1, f"{path.name} is not TOML: {error}") from None
    unknown = set(data) - SECTIONS
    if unknown:
        raise ReadError(
            1, f"{path.name}: unknown section {sorted(unknown)[0]!r}; known are {sorted(SECTIONS)}"
        )
    for section in data:
        if not isinstance(data[section], dict):
            raise ReadError(_line(text, section), f"{path.name}: {section!r} must be a section, [{section}]")
    base = load().__dict__ if path != DEFAULT else {"symbols": {}, "functions": {}, "inline": ()}
    symbols, functions = dict(base["symbols"]), dict(base["functions"])
    for letter, quantity in data.get("symbols", {}).items():
        if not isinstance(quantity, str):
            raise ReadError(
                _line(text, letter), f"{path.name}: {letter!r} must name a quantity, not {quantity!r}"
            )
        symbols[letter_name(letter)] = quantity
    for letter, args in data.get("functions", {}).items():
        if not (isinstance(args, list) and all(isinstance(a, str) for a in args)):
            raise ReadError(_line(text, letter), f"{path.name}: {letter!r} must list its arguments' letters")
        functions[letter_name(letter)] = tuple(map(letter_name, args))
    inline = data.get("inline", {}).get("quantities", list(base["inline"]))
    if not (isinstance(inline, list) and all(isinstance(q, str) for q in inline)):
        raise ReadError(_line(text, "quantities"), f"{path.name}: 'quantities' must list names of quantities")
    return Notation(symbols, functions, tuple(inline))


def require_known(notation: Notation, own: tuple[str, ...], rod: str) -> None:
    """Every letter stands for a quantity of the theory or for a parameter that a rod has of its ``own``.

    Raises:
        ReadError: for another name, with the nearest known one; for a parameter with a quantity's name.
    """
    quantities = {*load().symbols.values(), *MADE}
    for name in own:
        if name in quantities:
            raise ReadError(
                1, f"the parameter {name!r} of {rod} has the name of a quantity of the ledger; rename it"
            )
    known = [*load().symbols.values(), *own]
    for letter, quantity in notation.symbols.items():
        if quantity not in known:
            (nearest,) = get_close_matches(quantity, known, 1, cutoff=0)
            raise ReadError(
                1,
                f"the notation: {letter!r} stands for {quantity!r}, neither a quantity of the theory nor a "
                f"parameter of {rod}; the nearest name is {nearest!r}",
            )


def _line(text: str, key: str) -> int:
    bare = key.replace("\\", "\\\\")
    return next((n for n, row in enumerate(text.splitlines(), 1) if bare in row or key in row), 1)
