r"""A ``.tex`` source to its displays, tables and inline formulas, each with its line.

Comments are blanked, so that every line number is the source's. Only what stands between
``\begin{document}`` and ``\end{document}`` (or the whole file, when it has neither) is looked at.
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import dataclass

from derivation.errors import ReadError

MAX_CHARACTERS = 4_000_000
DISPLAYS = ["equation", "align", "alignat", "gather", "multline", "eqnarray", "displaymath"]
_EDGE = re.compile(
    r"\\begin\s*\{(?P<begin>[a-zA-Z]+)\*?\}|\\end\s*\{(?P<end>[a-zA-Z]+)\*?\}"
    r"|(?<!\\)(?P<open>\\\[)|(?<!\\)(?P<close>\\\])|(?<!\\)(?P<dollars>\$\$)|(?<!\\)(?P<dollar>\$)"
)
_TABULAR = r"\\begin\{(?P<name>tabular)\}\s*(?:\[[^\]]*\])?\{[^{}]*\}"
_COLUMNS = re.compile(r"\s*\{[^{}]*\}")  # of an alignat
_OTHER_FILE = re.compile(r"\\(?:input|include|subfile)\s*\{[^{}]*\}")
_LABEL = re.compile(r"\\label\s*\{([^{}]*)\}")


@dataclass(frozen=True)
class Display:
    """A displayed formula: the text inside, the line of its beginning and of its text, and its place.

    ``after`` is the label that was last seen before it, with a count when several displays share it;
    ``intro`` is the sentence that leads to it.
    """

    text: str
    line: int
    text_line: int
    after: str
    intro: str


@dataclass(frozen=True)
class Cell:
    text: str
    line: int


@dataclass(frozen=True)
class Table:
    """A tabular with the label of its table; ``rows[0]`` is the header."""

    label: str
    line: int
    rows: tuple[tuple[Cell, ...], ...]


@dataclass(frozen=True)
class Inline:
    r"""A formula in running text, ``$...$``."""

    text: str
    line: int


@dataclass(frozen=True)
class Source:
    displays: tuple[Display, ...]
    tables: tuple[Table, ...]
    inline: tuple[Inline, ...]


def scan(text: str) -> Source:
    """Find the displays, tables and inline formulas of a LaTeX source.

    Raises:
        ReadError: a file that is too large or goes on in another one, or a display that is not closed (with
            the line of its beginning).
    """
    if len(text) > MAX_CHARACTERS:
        raise ReadError(1, f"a file of {len(text)} characters; at most {MAX_CHARACTERS} are read")
    body = _document(_without_comments(text))
    if other := _OTHER_FILE.search(body):
        problem = "this file alone is read; put what the other one holds in its place"
        raise ReadError(_line(body, other.start()), f"{other[0][:60]}: {problem}")
    displays, inline = _formulas(body)
    return Source(tuple(displays), tuple(_tables(body)), tuple(inline))


def _without_comments(text: str) -> str:
    """Comments blanked; newlines stay."""
    text = re.sub(r"(?<!\\)((?:\\\\)*)%[^\n]*", r"\1", text.replace("\r\n", "\n").replace("\r", "\n"))
    kept, at = [], 0
    for begin, inside, end in _environments(text, r"\\begin\{(?P<name>comment|verbatim)\}"):
        after = end + len(rf"\end{{{begin['name']}}}")
        kept += [text[at : begin.start()], "\n" * text.count("\n", inside, end)]
        at = after
    return "".join([*kept, text[at:]])


def _environments(text: str, opening: str) -> Iterator[tuple[re.Match[str], int, int]]:
    """Environments that begin so and are closed: the match, where the inside begins and where it ends."""
    at, open_ = 0, set()
    for begin in re.finditer(opening, text):
        name = begin["name"]
        if begin.start() < at or name in open_:
            continue
        end = text.find(rf"\end{{{name}}}", begin.end())
        if end < 0:
            open_.add(name)  # none of these is closed from here on
            continue
        yield begin, begin.end(), end
        at = end


def _document(text: str) -> str:
    """Everything outside the document blanked; newlines stay."""
    begin, end = text.find(r"\begin{document}"), text.find(r"\end{document}")
    bibliography = text.find(r"\begin{thebibliography}")
    first = begin + len(r"\begin{document}") if begin >= 0 else 0
    last = min((k for k in (end, bibliography) if k >= 0), default=len(text))
    return "\n" * text.count("\n", 0, first) + text[first:last]


def _line(text: str, at: int) -> int:
    return text.count("\n", 0, at) + 1


def _formulas(text: str) -> tuple[list[Display], list[Inline]]:
    """One pass over the edges of formulas; whichever opens must close before another opens."""
    displays: list[Display] = []
    inline: list[Inline] = []
    opened: tuple[str, int, int] | None = None  # what closes it, start of the edge, start of the text
    prose, label, count = 0, "start", 0
    for m in _EDGE.finditer(text):
        kind = _closing(m)
        if opened is None:
            if kind is None or kind.startswith("end "):
                continue
            if kind in (r"\]",) and m["close"]:
                raise ReadError(_line(text, m.start()), r"\] without \[")
            columns = _COLUMNS.match(text, m.end()) if kind == "alignat" else None
            opened = (kind, m.start(), columns.end() if columns else m.end())
            continue
        if not _closes(m, opened[0]):
            if m["begin"] in DISPLAYS or m["open"] or m["dollars"]:
                raise _unclosed(text, opened)
            continue
        closing, start, inside = opened
        opened = None
        content = text[inside : m.start()]
        if closing == "$":
            inline.append(Inline(content, _line(text, start)))
            continue
        before = text[prose:start]
        for found in _LABEL.findall(before):
            label, count = (found.strip(), 0) if found.startswith("eq:") else (label, count)
        own = _LABEL.findall(content)
        count += not own
        place = f"after {label}" + (f"/{count}" if count > 1 else "")
        displays.append(
            Display(content, _line(text, start), _line(text, inside), place, before.split(". ")[-1].strip())
        )
        label, count = (own[-1].strip(), 0) if own else (label, count)
        prose = m.end()
    if opened is not None:
        raise _unclosed(text, opened)
    return displays, inline


def _closing(m: re.Match[str]) -> str | None:
    """What would close the formula that this edge opens; 'end x' for an end, None for no formula's edge."""
    if m["begin"]:
        return m["begin"] if m["begin"] in DISPLAYS else None
    if m["end"]:
        return f"end {m['end']}"
    return r"\]" if m["open"] or m["close"] else "$$" if m["dollars"] else "$"


def _closes(m: re.Match[str], wanted: str) -> bool:
    return bool(
        m["end"] == wanted
        or (wanted == r"\]" and m["close"])
        or (wanted == "$$" and m["dollars"])
        or (wanted == "$" and m["dollar"])
    )


def _unclosed(text: str, opened: tuple[str, int, int]) -> ReadError:
    wanted = opened[0] if opened[0] in (r"\]", "$$", "$") else rf"\end{{{opened[0]}}}"
    return ReadError(_line(text, opened[1]), f"the formula that begins here is not closed; expected {wanted}")


def _tables(text: str) -> list[Table]:
    tables = []
    for begin, inside, closed in _environments(text, _TABULAR):
        end = text.find(r"\end{table", closed)
        start = text.rfind(r"\begin{table", 0, begin.start())
        labels = _LABEL.findall(text[max(start, 0) : begin.start()] + text[closed : max(end, closed)])
        line = _line(text, begin.start())
        label = next((x for x in labels if x.startswith("tab:")), f"table on line {line}")
        rows, at = [], inside
        for row in re.split(r"(\\\\(?:\s*\[[^\]]*\])?)", text[inside:closed]):
            if not row.startswith(r"\\"):
                cells = _cells(row, text, at)
                if any(c.text for c in cells):
                    rows.append(cells)
            at += len(row)
        tables.append(Table(label, _line(text, max(start, 0) or begin.start()), tuple(rows)))
    return tables


def _cells(row: str, text: str, at: int) -> tuple[Cell, ...]:
    cells = []
    for part in re.split(r"(?<!\\)(&)", row):
        if part != "&":
            bare = re.sub(r"\\(?:colrule|hline|toprule|midrule|bottomrule)(?![a-zA-Z])", "", part).strip()
            cells.append(Cell(bare, _line(text, at + part.rfind(bare))))
        at += len(part)
    return tuple(cells)
