"""Amplitude and frequency of an oscillation from a uniformly sampled signal, or its rest; with their errors.

As in the paper (sec:numerics) both are read from the second half of the signal: A is half of its peak-to-peak
value, ω the dominant peak of its Hann-windowed spectrum. Peaks are not samples: the extrema are those of the
polynomial through the samples around them, and the peak of the spectrum is found as a continuous maximum, so
that neither the sampling step nor the width of a frequency bin limits the result.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
State = Literal["settled", "decayed", "buckled", "not finished"]

SETTLED = 1e-3  # change of A from the third to the last quarter, relative, below which it has settled
DECAYED = 1e-6  # the signal in the last quarter, in its unit, below which only noise is left
AT_REST = 1e-9  # departure from the last value over a half, relative, that is rounding and nothing else
FEWEST_PERIODS = 4  # in a quarter of the signal, for its frequency to be read
EPS = float(np.finfo(float).eps)
REACH = 3  # samples on either side of an extremum that its polynomial goes through


@dataclass(frozen=True)
class Reading:
    """What a signal says about its oscillation, in the units of the signal and of its time.

    A_tip, omega: from the second half; None where the signal does not oscillate there or drifts by more
    than it does, omega also where that is too short. *_error: the difference between the third and the last
    quarter, which is what has not settled, plus that between two ways to interpolate or to window; not the
    error of the integration behind the signal. growth: rate of the amplitude's change between these quarters,
    d ln A/dt; None as A_tip.
    y_tip: where the signal comes to rest, if that is not 0 (state "buckled"); its error: how far it was from
    there in the last quarter.
    """

    state: State
    A_tip: float | None
    A_tip_error: float | None
    omega: float | None
    omega_error: float | None
    growth: float | None
    y_tip: float | None = None
    y_tip_error: float | None = None


def read(time: Array, signal: Array) -> Reading:
    """The oscillation of `signal` (m,), sampled uniformly at `time` (m,), in its second half."""
    half, quarter = time.size // 2, time.size // 4
    late_time, late = time[half:], signal[half:]
    decayed = np.abs(late[quarter:]).max() < DECAYED
    if not decayed and (moved := _moved_to_rest(late[:quarter], late[quarter:])) is not None:
        return Reading("buckled", None, None, None, None, None, float(late[-1]), moved)
    A, third, last = amplitude(late), amplitude(late[:quarter]), amplitude(late[quarter:])
    if A is None or third is None or last is None:
        return Reading("decayed" if decayed else "not finished", None, None, None, None, None)
    omega = omega_error = None
    if len(_turns(late[:quarter])) / 2 >= FEWEST_PERIODS and not decayed:
        omega = frequency(late_time, late)
        if omega * (late_time[quarter] - late_time[0]) < np.pi * FEWEST_PERIODS:
            return Reading("not finished", None, None, None, None, None)  # it drifts by more than it beats
        first, second = (
            frequency(late_time[part], late[part]) for part in (slice(quarter), slice(quarter, None))
        )
        omega_error = abs(second - first) + abs(frequency(late_time, late, 2) - omega)
    interpolation = abs(A - (amplitude(late, REACH - 1) or A))
    growth = float(np.log(last / third) / (late_time[quarter] - late_time[0]))

    settled: State = "settled" if abs(last - third) < SETTLED * last else "not finished"
    state: State = "decayed" if decayed else settled
    return Reading(state, A, abs(last - third) + interpolation, omega, omega_error, growth)


def _moved_to_rest(third: Array, last: Array) -> float | None:
    """How far the signal was in its last quarter from where it ends; None unless it comes to rest there.

    y + c e^{−rt} that moves by a in the one and by a' = ρa in the other has still ρa'/(1 − ρ) to go. From its
    end it was at most d = a + a' and d' = a' away: with d' <= d/3 is ρ <= 1/2, and it goes no more than d'.
    """
    if not third.size:
        return None
    end = last[-1]
    before, moved = float(np.abs(third - end).max()), float(np.abs(last - end).max())
    approaches = moved <= before / 3 and moved < SETTLED * abs(end)
    return max(moved, EPS * abs(float(end))) if approaches or before < AT_REST * abs(end) else None


def amplitude(signal: Array, reach: int = REACH) -> float | None:
    """Half the distance between the highest maximum and the lowest minimum; None without one of each."""
    values = extrema(signal, reach)
    if values.size < 2:
        return None
    return float(values.max() - values.min()) / 2 or None


def extrema(signal: Array, reach: int = REACH) -> Array:
    """Values of a uniformly sampled signal at its turning points, between the samples.

    Each is the extremum of the polynomial of degree 2·reach through the samples around a turn: its error
    falls like the sampling step to the power 2·reach + 1. Turns nearer to an end than `reach` are left out.
    """
    turns = _turns(signal)
    turns = turns[(turns >= reach) & (turns < signal.size - reach)]
    offsets = np.arange(-reach, reach + 1)
    powers = np.arange(2 * reach + 1)
    # coefficients of p(s), s in sampling steps from the turn: p(offsets) = samples
    p = signal[turns[:, None] + offsets] @ np.linalg.inv(offsets[:, None] ** powers.astype(float)).T
    s = np.zeros(turns.size)
    for _ in range(6):  # Newton for p'(s) = 0
        slope = (p[:, 1:] * powers[1:] * s[:, None] ** powers[:-1]).sum(axis=1)
        curvature = (p[:, 2:] * powers[2:] * powers[1:-1] * s[:, None] ** powers[:-2]).sum(axis=1)
        s = np.clip(s - slope / curvature, -1.0, 1.0)
    return np.asarray((p * s[:, None] ** powers).sum(axis=1))


def frequency(time: Array, signal: Array, power: int = 1) -> float:
    """Angular frequency at the highest peak of the spectrum under a Hann window (to this power), at ω > 0.

    The peak is where d|S|²/dω = 2 Re(S* S') = 0 for S(ω) = Σ w y e^{−iωt}, found within a bin of the
    discrete spectrum's largest value.
    """
    from scipy.optimize import brentq

    t = time - time.mean()
    weighted = np.hanning(t.size + 2)[1:-1] ** power * (signal - signal.mean())
    bins = np.abs(np.fft.rfft(weighted))
    bin_width = 2 * np.pi / (t[1] - t[0]) / t.size

    def spectrum(omega: float) -> complex:
        return complex((weighted * np.exp(-1j * omega * t)).sum())

    def slope(omega: float) -> float:
        wave = weighted * np.exp(-1j * omega * t)
        return float((np.conj(wave.sum()) * (-1j * t * wave).sum()).real)

    near = (1 + int(bins[1:-1].argmax()) + np.linspace(-1, 1, 9)) * bin_width
    peak = 1 + int(np.abs([spectrum(omega) for omega in near[1:-1]]).argmax())
    return float(brentq(slope, near[peak - 1], near[peak + 1], rtol=1e-14))


def _turns(signal: Array) -> NDArray[np.intp]:
    """Indices of the samples that are not between their neighbours."""
    steps = np.diff(signal)
    return np.flatnonzero(steps[:-1] * steps[1:] < 0) + 1
