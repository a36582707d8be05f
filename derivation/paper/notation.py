"""Which letter of a paper stands for which quantity: data, read from a TOML file.

Sections: ``[symbols]`` maps a letter (as LaTeX, in any spelling) to a quantity of the theory;
``[functions]`` maps a letter to the names of its arguments, which decides whether ``f(u)`` is a value or a
product; ``[inline]`` lists the quantities whose definitions stand in running text.
"""

from __future__ import annotations

import tomllib
from dataclasses import dataclass
from functools import cache
from pathlib import Path

from derivation.errors import ReadError

DEFAULT = Path(__file__).with_name("notation.toml")
SECTIONS = {"symbols", "functions", "inline"}


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
        ReadError: not TOML, an unknown section, an entry that is not a text.
        OSError: the file cannot be read.
    """
    from derivation.paper.parse import letter_name

    text = path.read_text(encoding="utf-8")
    try:
        data = tomllib.loads(text)
    except tomllib.TOMLDecodeError as error:
        raise ReadError(1, f"{path.name} is not TOML: {error}") from None
    unknown = set(data) - SECTIONS
    if unknown:
        raise ReadError(
            1, f"{path.name}: unknown section {sorted(unknown)[0]!r}; known are {sorted(SECTIONS)}"
        )
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
    inline = tuple(data.get("inline", {}).get("quantities", base["inline"]))
    return Notation(symbols, functions, inline)


def _line(text: str, key: str) -> int:
    bare = key.replace("\\", "\\\\")
    return next((n for n, row in enumerate(text.splitlines(), 1) if bare in row or key in row), 1)
