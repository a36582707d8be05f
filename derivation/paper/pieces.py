r"""A display cut into its equations at ``\\``, ``\quad`` and commas."""

from __future__ import annotations

from dataclasses import dataclass

from lark import Token

from derivation.paper.tokens import CLOSES


@dataclass(frozen=True)
class Piece:
    """Part of a display between separators: an equation, or the place where the ones before it hold."""

    tokens: tuple[Token, ...]
    label: str | None
    is_place: bool


def split(tokens: list[Token]) -> list[Piece]:
    r"""Cut a display into equations at ``\\``, ``\quad`` and commas; rows that continue are joined.

    A row continues when it begins with a relation, or with a sign and holds no relation of its own, or when
    the row before it ends in a sign or relation. Labels: with two or more in the display, each names the
    rows up to its own; with one, all.
    """
    pieces: list[tuple[list[Token], int, bool]] = []
    labels: list[tuple[int, str]] = []
    depth = row = 0
    now: list[Token] = []
    place = False

    def flush() -> None:
        nonlocal now, place
        if any(t.type != "WORD" for t in now) and now:
            if not place and pieces and _continues(now, pieces[-1]):
                pieces[-1][0].extend(now)
            else:
                pieces.append((now, row, place))
        now, place = [], False

    for t in tokens:
        depth += (t.type in CLOSES) - (t.type in CLOSES.values())
        if t.type == "LABEL":
            labels.append((row, str(t)))
        elif depth == 0 and t.type == "AT":
            flush()
            place = True
        elif depth == 0 and t.type in ("ROW", "COMMA", "QUAD"):
            if not (place and not now):
                flush()
            row += t.type == "ROW"
        elif not (depth == 0 and t.type in ("AMP", "STOP")):
            now.append(t)
    flush()
    return [Piece(tuple(ts), _label_of(r, labels), p) for ts, r, p in pieces]


def _continues(now: list[Token], before: tuple[list[Token], int, bool]) -> bool:
    if before[2]:
        return False
    if before[0][-1].type in ("SIGN", "REL", "DOT", "OVER") or now[0].type in ("REL", "DOT"):
        return True
    return now[0].type == "SIGN" and not _has_relation(now)


def _has_relation(tokens: list[Token]) -> bool:
    depth = 0
    for t in tokens:
        depth += (t.type in CLOSES) - (t.type in CLOSES.values())
        if depth == 0 and t.type == "REL":
            return True
    return False


def _label_of(row: int, labels: list[tuple[int, str]]) -> str | None:
    if not labels:
        return None
    if len(labels) == 1:
        return labels[0][1]
    return next((name for r, name in labels if r >= row), labels[-1][1])
