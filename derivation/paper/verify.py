"""A paper decided as a whole: every equation with its status, and what is wrong with those that differ."""

from __future__ import annotations

from dataclasses import dataclass

from derivation.paper.kinds import grouped, stage_of
from derivation.paper.ledger import ledger
from derivation.paper.lower import Lowering
from derivation.paper.meanings import FIELDS
from derivation.paper.notation import Notation, require_known
from derivation.paper.numbers import NumericRow, numeric_rows
from derivation.paper.read import read
from derivation.paper.reasons import UndecidedError, UnfitError
from derivation.paper.repair import Repair, repair
from derivation.paper.rows import Row
from derivation.paper.syntax import Apply, Equation, Expr, Relation, Sym
from derivation.paper.theory import Theory
from derivation.paper.typeset import formula, latex, tree
from derivation.pipeline import Derivation, derive


@dataclass(frozen=True)
class Finding:
    """A row of the ledger, ready to be shown; mathematics as LaTeX.

    Attributes:
        group: the part of the theory that the equation belongs to.
        difference: left minus right, empty when the equation holds.
        repair: for one that does not hold, the smallest edit that makes it hold.
        place: where it holds, u = 0 or u = 1, if not everywhere.
        theirs: what was read, typeset again.
        derived: what the derivation has for the letter on the left, None when no single letter stands there.
        stage: the module of the derivation that it comes from.
    """

    row: Row
    group: str
    difference: str
    repair: Repair | None
    place: Relation | None
    theirs: str
    derived: Expr | None
    stage: str

    @property
    def label(self) -> str:
        return self.row.equation.label


@dataclass(frozen=True)
class Verification:
    """All equations and the numeric tables of a source."""

    findings: tuple[Finding, ...]
    tables: tuple[NumericRow, ...]
    labels: tuple[str, ...]
    theory: Theory
    notation: Notation


def verify(
    text: str, notation: Notation, derivation: Derivation | None = None, only: str | None = None
) -> Verification:
    """Read a paper's LaTeX and decide each of its equations.

    ``only``: the label of an equation or of a display; the others are read but not reported.

    Raises:
        ReadError: the text cannot be read, with the line and what was expected; the notation has a letter for
            what is no quantity.
    """
    paper = read(text, notation)
    theory = Theory(derive() if derivation is None else derivation)
    law = theory.d.law
    require_known(notation, (*law.parameters[5:], *law.constants), theory.d.model.name)
    wanted = [e for e in paper.equations if only is None or only in (e.label, display_of(e))]
    whole = {display_of(e) for e in wanted}  # conditions are judged beside those they stand with
    rows = ledger([e for e in paper.equations if display_of(e) in whole], notation, theory)
    labels = {e.label for e in wanted}
    findings = tuple(_finding(row, notation, theory) for row in rows if row.equation.label in labels)
    everything = tuple(e.label for e in paper.equations)
    return Verification(findings, tuple(numeric_rows(paper.tables, notation)), everything, theory, notation)


def display_of(equation: Equation) -> str:
    """The label of the display that an equation stands in."""
    return equation.label.rpartition(".")[0] or equation.label


def _finding(row: Row, notation: Notation, theory: Theory) -> Finding:
    wrong = row.status == "differs"
    place = Lowering(row.equation, notation, theory).where
    return Finding(
        row,
        grouped(row.equation, notation, theory),
        formula(row.difference, notation) if row.difference else row.reason if wrong else "",
        repair(row, notation, theory) if wrong else None,
        place,
        read_back(row.equation, place),
        derived_form(row.equation, notation, theory),
        stage_of(row.equation, notation, theory),
    )


def derived_form(equation: Equation, notation: Notation, theory: Theory) -> Expr | None:
    """The derivation's own formula for the letter on the left; None where no single letter stands there."""
    body = equation.body
    if not isinstance(body, Relation):
        return None
    head = body.left.fn if isinstance(body.left, Apply) else body.left
    if not isinstance(head, Sym) or notation.quantity(head.name) in (*FIELDS, None):
        return None
    low = Lowering(equation, notation, theory)
    low.indices = dict.fromkeys(low.free, 0)
    try:
        value = low.scalar(body.left)
    except (UndecidedError, UnfitError):
        return None
    name = notation.quantity(head.name)
    value = theory.landau.get(str(name), value)
    value = theory.canonical(value) if value.is_atom else theory.restored(value)
    return None if value.is_atom else tree(value, notation)


def read_back(equation: Equation, place: Relation | None) -> str:
    """What was read of an equation, typeset again, with the place where it holds."""
    at = rf" \quad \mathrm{{at}}\ {latex(place)}" if place is not None else ""
    return latex(equation.body) + at
