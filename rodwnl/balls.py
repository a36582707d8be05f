"""Balls that contain the truth: python-flint's Arb numbers, for the closed forms and for the proofs.

python-flint is optional (the extra `certified`) and imported when first needed. A ball that contains 0 makes
a quotient infinite and a comparison false: then nothing is proved, and nothing wrong is.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from fractions import Fraction
from typing import Any

from rodwnl.errors import ComputationError, InputError
from rodwnl.fields import Scalar, moment
from rodwnl.uniformrod import Balance

NARROWEST_STRETCH = 50  # the first X around the float64 stretch has the radius 2^−50
MOST_PIECES = 1000  # of an interval of stretches, before the proof is given up


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


@contextmanager
def series_terms(count: int) -> Iterator[None]:
    """The number of terms that series carry inside a `with` block."""
    context = flint().ctx
    before, context.cap = context.cap, count
    try:
        yield
    finally:
        context.cap = before


class BallNumbers:
    """Complex balls (acb) at the working precision of the moment, for rodwnl/closedform.py."""

    def number(self, value: Fraction) -> Scalar:
        f = flint()
        return f.acb(f.fmpq(value.numerator, value.denominator))

    def exp(self, z: Scalar) -> Scalar:
        return z.exp()

    def sqrt(self, z: Scalar) -> Scalar:
        return square_root(z)

    def log(self, z: Scalar) -> Scalar:
        return z.log()

    def sin(self, z: Scalar) -> Scalar:
        return z.sin()

    def cos(self, z: Scalar) -> Scalar:
        return z.cos()

    def stretch(self, force: Scalar, balance: Balance, start: Callable[[float], float]) -> Scalar:
        """ν for every force of a ball (or of a series in one): dν/dF = −1/K1, so it lies between the ends'.

        Proved is K1 > 0 from ν to 1: there is no other ν between, and this one belongs to the unloaded rod.
        """
        f = flint()
        F = leading(force).real
        ends = [_stretch_at(f.acb(end), balance, start) for end in (F.lower(), F.upper())]
        nu = ends[0].union(ends[1])
        _require_positive(lambda x: balance(f.acb(F), f.acb(x))[1].real, nu.union(f.arb(1)))
        if force is leading(force):
            return f.acb(nu)
        return f.acb_series([nu, -force[1] / balance(f.acb(F), f.acb(nu))[1]])

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


def _stretch_at(force: Scalar, balance: Balance, start: Callable[[float], float]) -> Scalar:
    """ν under one force: N(X) = m − (F1(m) + F)/K1(X) inside X proves one solution in X, and that N has it.

    (Interval Newton; Moore 1966.) Raises ComputationError where no X is found.
    """
    f = flint()

    def newton(X: Scalar) -> Scalar:
        middle = f.acb(X.mid())
        return X.mid() - (balance(force, middle)[0] / balance(force, f.acb(X))[1]).real

    try:
        near = f.arb(start(float(force.real.mid())))
    except InputError as error:
        raise ComputationError(str(error)) from None
    for n in range(NARROWEST_STRETCH, 0, -4):
        X = f.arb(near.mid(), f.arb(2) ** -n)
        inner = newton(X)
        if not X.contains_interior(inner):
            continue
        while inner.rad() < X.rad() / 2:
            X = inner
            inner = newton(X)
        return X.intersection(inner)
    raise ComputationError(f"no straight rod is proved to exist under force {force.real.str(8)}")


def _require_positive(value: Callable[[Scalar], Scalar], interval: Scalar) -> None:
    """K1 > 0 on an interval of ν, cut until each piece shows it, or ComputationError."""
    pieces, stack = 0, [interval]
    while stack:
        piece = stack.pop()
        pieces += 1
        if not value(piece) > 0:
            if pieces > MOST_PIECES:
                raise ComputationError(
                    f"the stretch stiffness may vanish for a stretch in {piece.str(6)}, between the straight "
                    f"rod's and 1"
                )
            stack += [piece.lower().union(piece.mid()), piece.mid().union(piece.upper())]


def square_root(z: Scalar) -> Scalar:
    """A square root of a ball (or of a series in one), analytic unless it contains 0: the cut is opposite."""
    return z.sqrt() if leading(z).real.mid() >= 0 else 1j * (-z).sqrt()


def leading(z: Scalar) -> Scalar:
    """The value of a ball, or of a series at its centre."""
    return z[0] if hasattr(z, "coeffs") else z


def enclosure(x: Scalar, digits: int) -> dict[str, str]:
    """{"mid", "rad"} of a real ball, as decimal texts: |x − mid| <= rad holds for the texts as they stand."""
    text = str(x.str(digits)).strip("[]")
    mid, _, rad = text.partition("+/- ")
    return {"mid": mid.strip() or "0", "rad": rad or "0"}  # of a ball that contains 0 no digit is known


def relative_accuracy(x: Scalar) -> float:
    """Correct decimal digits of a real ball; −∞ for one that contains 0."""
    return float(x.rel_accuracy_bits()) * 0.30103 if not x.contains(0) else float("-inf")
