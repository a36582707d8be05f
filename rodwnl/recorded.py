"""Complex numbers that write down what is done to them, as real arithmetic for a compiler.

A formula called with `Recorded` numbers leaves on their `Tape` one line for each real operation, so that what
is compiled has one source with what runs on arrays. With Jets of them it leaves its derivatives as well.
"""

from __future__ import annotations

import re
from collections.abc import Iterable
from typing import Any

Real = float | str  # a known number, or the name of one

PRELUDE = """\
#define above_zero(x) ((x) > 0 ? 1.0 : 0.0)
#define by_sign(x, positive, negative) ((x) >= 0 ? (positive) : (negative))
"""


class Tape:
    """Real operations in C, each with its name; the same one is written once.

    powers: real and imaginary parts of the arguments of exponentials. The values go by the names powerN_re
    and powerN_im: the compiler is given them, so that its loops contain nothing but arithmetic.
    """

    def __init__(self) -> None:
        self.lines: dict[str, str] = {}
        self.powers: list[tuple[Real, Real]] = []

    def call(self, text: str, *arguments: Real) -> str:
        """The name of what `text` says of these arguments."""
        text = text.format(*arguments)
        return self.lines.setdefault(text, f"t{len(self.lines)}")

    def add(self, a: Real, b: Real) -> Real:
        if isinstance(a, float) and isinstance(b, float):
            return a + b
        return b if a == 0 else a if b == 0 else self.call("{} + {}", *sorted((a, b), key=str))

    def negative(self, a: Real) -> Real:
        return -a if isinstance(a, float) else self.call("-{}", a)

    def subtract(self, a: Real, b: Real) -> Real:
        if isinstance(a, float) and isinstance(b, float):
            return a - b
        return self.negative(b) if a == 0 else a if b == 0 else self.call("{} - {}", a, b)

    def multiply(self, a: Real, b: Real) -> Real:
        if isinstance(a, float) and isinstance(b, float):
            return a * b
        if a == 0 or b == 0:
            return 0.0
        return b if a == 1 else a if b == 1 else self.call("{}*{}", *sorted((a, b), key=str))

    def needed(self, results: Iterable[Real]) -> tuple[list[str], set[str]]:
        """The lines that lead to these, as C, and the names that they use."""
        used = {name for name in results if isinstance(name, str)}
        kept = []
        for text, name in reversed(self.lines.items()):
            if name in used:
                kept.append(f"const double {name} = {text};")
                used.update(re.findall(r"[a-z]\w*", text))
        return kept[::-1], used


class Recorded:
    """re + i im on a tape."""

    __slots__ = ("im", "re", "tape")

    def __init__(self, tape: Tape, re: Real, im: Real = 0.0) -> None:
        self.tape, self.re, self.im = tape, re, im

    def _with(self, other: Any) -> Any:
        if isinstance(other, Recorded):
            return other
        try:
            number = complex(other)
        except TypeError:  # an array of Recorded numbers, or a Jet: its own operation works on each
            return NotImplemented
        return Recorded(self.tape, number.real, number.imag)

    def __add__(self, other: Any) -> Any:
        if (b := self._with(other)) is NotImplemented:
            return b
        return Recorded(self.tape, self.tape.add(self.re, b.re), self.tape.add(self.im, b.im))

    def __neg__(self) -> Recorded:
        return Recorded(self.tape, self.tape.negative(self.re), self.tape.negative(self.im))

    def __sub__(self, other: Any) -> Any:
        if (b := self._with(other)) is NotImplemented:
            return b
        return Recorded(self.tape, self.tape.subtract(self.re, b.re), self.tape.subtract(self.im, b.im))

    def __rsub__(self, other: Any) -> Any:
        return -self + other

    def __mul__(self, other: Any) -> Any:
        if (b := self._with(other)) is NotImplemented:
            return b
        t, a = self.tape, self
        return Recorded(
            t,
            t.subtract(t.multiply(a.re, b.re), t.multiply(a.im, b.im)),
            t.add(t.multiply(a.re, b.im), t.multiply(a.im, b.re)),
        )

    __radd__, __rmul__ = __add__, __mul__

    def __truediv__(self, other: Any) -> Any:
        """By the square of the modulus, which overflows where numbers beyond 1e154 are divided."""
        if (b := self._with(other)) is NotImplemented:
            return b
        t = self.tape
        inverse = t.call("1/({})", t.add(t.multiply(b.re, b.re), t.multiply(b.im, b.im)))
        return self * b.conjugate() * Recorded(t, inverse)

    def __rtruediv__(self, other: Any) -> Any:
        return self._with(other) / self

    def __gt__(self, zero: float) -> Recorded:
        """1 or 0, as the truth of arrays counts."""
        return Recorded(self.tape, self.tape.call("above_zero({})", self.tape.subtract(self.re, zero)))

    @property
    def real(self) -> Recorded:
        return Recorded(self.tape, self.re)

    @property
    def imag(self) -> Recorded:
        return Recorded(self.tape, self.im)

    # NumPy's functions of objects call methods of their names.

    def conjugate(self) -> Recorded:
        return Recorded(self.tape, self.re, self.tape.negative(self.im))

    def sqrt(self) -> Recorded:
        """(|z| + |x|)/2 is the square of the larger part of the root, without cancellation."""
        t = self.tape
        modulus = t.call("sqrt({})", t.add(t.multiply(self.re, self.re), t.multiply(self.im, self.im)))
        larger = t.call("sqrt(0.5*({} + fabs({})))", modulus, self.re)
        smaller = t.call("0.5*fabs({})/{}", self.im, larger)
        upper = t.call("by_sign({}, {}, {})", self.re, smaller, larger)
        return Recorded(
            t,
            t.call("by_sign({}, {}, {})", self.re, larger, smaller),
            t.call("copysign({}, {})", upper, self.im),
        )

    def exp(self) -> Recorded:
        number = len(self.tape.powers)
        self.tape.powers.append((self.re, self.im))
        return Recorded(self.tape, f"power{number}_re", f"power{number}_im")
