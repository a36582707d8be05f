"""A row of the ledger."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

from derivation.paper.algebra import Poly
from derivation.paper.syntax import Equation

Status = Literal["premise", "verified", "differs", "not decided"]


@dataclass(frozen=True)
class Row:
    """One equation decided.

    Attributes:
        reason: in words, what the status rests on.
        difference: left minus right after reduction; zero when the equation holds.
        remark: what is unusual about an equation that holds, empty as a rule; the reason ends with it.
    """

    equation: Equation
    status: Status
    reason: str
    difference: Poly
    remark: str = ""
