"""Balls that contain the truth: python-flint's Arb numbers, for the closed forms and for the proofs.

python-flint is optional (the extra `certified`) and imported when first needed. A ball that contains 0 makes
a quotient infinite and a comparison false: then nothing is proved, and nothing wrong is.
"""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from fractions import Fraction
from typing import Any

from rodwnl.errors import ComputationError, InputError
from rodwnl.fields import Scalar, moment


def flint() -> Any:
    """The module `flint`, or InputError with what to install."""
    try:
        import flint
    except ImportError:
        raise InputError(
            "certified bounds need python-flint, which is not installed: pip install 'rodwnl[certified]'"
        ) from None
    return flint


@contextmanager
def working_bits(bits: int) -> Iterator[None]:
    """Arb's working precision inside a `with` block."""
    context = flint().ctx
    before = context.prec, context.cap
    context.prec, context.cap = bits, 2  # series, where used, carry a value and one derivative
    try:
        yield
    finally:
        context.prec, context.cap = before


class BallNumbers:
    """Complex balls (acb) at the working precision of the moment, for rodwnl/closedform.py."""

    def number(self, value: Fraction) -> Scalar:
        f = flint()
        return f.acb(f.fmpq(value.numerator, value.denominator))

    def exp(self, z: Scalar) -> Scalar:
        return z.exp()

    def sqrt(self, z: Scalar) -> Scalar:
        return square_root(z)

    def moment(self, p: int, a: Scalar) -> Scalar:
        """∫₀¹ u^p e^{au} du = ₁F₁(p+1; p+2; a)/(p+1), or by parts where a is surely not small."""
        if a.abs_lower() > p + 1:
            return moment(p, a, self.exp, series=False, tiny=0)
        return a.hypgeom_1f1(p + 1, p + 2) / (p + 1)

    def coincide(self, a: Scalar, b: Scalar) -> bool:
        """False where the balls are apart; balls that overlap prove nothing and are refused."""
        if (a - b).contains(0):
            raise ComputationError("two exponents are too close to tell whether they coincide (a resonance)")
        return False


def square_root(z: Scalar) -> Scalar:
    """A square root of a ball (or of a series in one), analytic unless it contains 0: the cut is opposite."""
    return z.sqrt() if leading(z).real.mid() >= 0 else 1j * (-z).sqrt()


def leading(z: Scalar) -> Scalar:
    """The value of a ball, or of a series at its centre."""
    return z[0] if hasattr(z, "coeffs") else z


def enclosure(x: Scalar, digits: int) -> dict[str, str]:
    """{"mid", "rad"} of a real ball, as decimal texts: |x − mid| <= rad holds for the texts as they stand."""
    text = str(x.str(digits)).strip("[]")
    mid, _, rad = text.partition(" +/- ")
    return {"mid": mid, "rad": rad or "0"}


def relative_accuracy(x: Scalar) -> float:
    """Correct decimal digits of a real ball; −∞ for one that contains 0."""
    return float(x.rel_accuracy_bits()) * 0.30103 if not x.contains(0) else float("-inf")
