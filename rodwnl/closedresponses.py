"""What exact responses have in common: known by name, as sums of exponentials and as values at the tip.

The problems are those of rodwnl/responses.py, for a rod of uniform stretch.
"""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

import mpmath as mp

from rodwnl.closedform import determinant
from rodwnl.fields import Exponents, Field, Key, Scalar, two_point
from rodwnl.responses import Pool
from rodwnl.straightrod import StraightRod


class ClosedResponses:
    """The rod at a crossing λ = iω, the exponents that occur there, and the responses found so far.

    prefix: of the names of the emitted forcings and tractions.
    """

    def __init__(self, straight: StraightRod, lam: Scalar, exponents: Exponents, prefix: str = "") -> None:
        self.straight, self.lam, self.exponents, self.prefix = straight, lam, exponents, prefix
        self.y_row, self.theta_row = straight("y_row"), straight("theta_row")
        self.drag = straight("drag_weights")
        self.known: Pool = {"lam": lam}
        self.fields: Pool = {"u": exponents.u(mp.mpf(1))}
        self.at_tip: Pool = {"u": mp.mpf(1)}

    def call(self, name: str, pool: Pool) -> Any:
        """An emitted function at what is known: fields, or their values at the tip."""
        return self.straight(self.prefix + name, **self.known, **pool)

    def keep(self, name: str, field: Field) -> None:
        slope = field.derivative()
        self.fields |= {name: field, f"{name}_u": slope, f"{name}_uu": slope.derivative()}
        self.at_tip |= {name: field.at_tip(), f"{name}_u": slope.at_tip()}

    def longitudinal(self, name: str, lam: Scalar, root: Key) -> None:
        """λΓ X − K1 X'' = f, X(0) = 0, S X(1) + S_u X'(1) = t; root: the key of s, K1 s² = λΓ."""
        forcing = self.exponents.promoted(self.call(f"{name}_forcing", self.fields))
        S, S_u = self.straight("x_tip_row", lam=lam)
        traction = self.call(f"{name}_traction", self.at_tip)
        field = forcing / (-self.straight("stretch_stiffness"))
        self.keep(name, two_point(field, root, traction / S_u, S / S_u))

    def tip_rows(self, lam: Scalar) -> list[tuple[Scalar, ...]]:
        """What multiplies (Y, Y', Θ, Θ')(1) in the stresses minus load."""
        return [self.straight(f"{name}_tip_row", lam=lam) for name in ("y", "theta")]

    def tip_drag(self) -> list[Scalar]:
        """What a load with drag adds where dA/dT acts: the part of the tip rows with λ, on the mode."""
        mode = [self.at_tip[name] for name in ("Y", "Y_u", "Theta", "Theta_u")]
        rows = zip(self.tip_rows(mp.mpc(0)), self.tip_rows(mp.mpc(1)), strict=True)
        return [sum((b - a) * m for a, b, m in zip(*pair, mode, strict=True)) for pair in rows]


def cramer(rows: list[list[Scalar]], right: Iterable[Scalar]) -> list[Scalar]:
    """The solution of a small linear system whose entries may differ by any factor."""
    whole, right = determinant(rows), list(right)
    return [
        determinant([[*row[:j], b, *row[j + 1 :]] for row, b in zip(rows, right, strict=True)]) / whole
        for j in range(len(rows))
    ]
