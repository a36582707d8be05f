"""Amplitude and frequency read from signals whose amplitude and frequency are known."""

import numpy as np
import pytest

from rodwnl.readout import amplitude, extrema, frequency, read

OMEGA, A = 193.13, 0.1


def signal(time: np.ndarray, phase: float = 0.3) -> np.ndarray:
    """Odd harmonics like the rod's tip, and an offset; the peaks of the sum are at ±A."""
    tau = OMEGA * time + phase
    return 0.01 + A * (np.cos(tau) + 0.02 * np.cos(3 * tau) + 1e-3 * np.cos(5 * tau)) / 1.021


def times(periods: float, per_period: int = 32) -> np.ndarray:
    return 2 * np.pi / OMEGA / per_period * np.arange(round(periods * per_period))


def test_amplitude_is_that_of_the_peaks_and_not_of_the_samples():
    time = times(60.3, 31.7)
    y = signal(time)
    assert amplitude(y) == pytest.approx(A, rel=1e-7)
    sampled = (y.max() - y.min()) / 2
    assert abs(sampled / A - 1) > 1e-6


def test_the_error_of_an_extremum_falls_with_the_seventh_power_of_the_step():
    def error(per_period: float) -> float:
        return float(np.abs(np.abs(extrema(np.sin(2 * np.pi / per_period * np.arange(400) + 0.4))) - 1).max())

    order = np.log(error(8.3) / error(16.6)) / np.log(2)
    assert 6.5 < order < 8.5


@pytest.mark.parametrize("periods", [20.37, 75.5, 151.2])
def test_frequency_is_found_far_below_a_bin(periods):
    time = times(periods)
    width = 2 * np.pi / time[-1]
    assert abs(frequency(time, signal(time)) - OMEGA) < 1e-4 * width


def test_a_steady_oscillation_has_settled():
    time = times(200)
    reading = read(time, signal(time))
    assert reading.state == "settled"
    assert abs(reading.A_tip - A) <= reading.A_tip_error < 1e-5 * A
    assert abs(reading.omega - OMEGA) <= reading.omega_error < 1e-4
    assert abs(reading.growth) < 1e-6


@pytest.mark.parametrize("rate", [-2.0, 0.7])
def test_an_oscillation_that_changes_has_not_finished_and_its_rate_is_read(rate):
    time = times(100)
    reading = read(time, np.exp(rate * time) * signal(time))
    assert reading.state == "not finished"
    assert reading.growth == pytest.approx(rate, rel=0.05)
    assert reading.A_tip_error > 0.1 * abs(rate) * time[-1] / 4 * reading.A_tip


def test_a_drift_is_not_an_oscillation():
    time = times(50)
    for y in (0.02 * np.cos(OMEGA * time) + 0.5 * time, 0.02 * np.cos(OMEGA * time) + np.exp(-time)):
        reading = read(time, y)
        assert reading.state == "not finished"
        assert reading.A_tip is reading.omega is reading.omega_error is reading.growth is None
    slow = read(time, 0.02 * np.cos(OMEGA * time) + 1e-3 * time)
    assert slow.omega == pytest.approx(OMEGA, rel=1e-4)


def test_an_oscillation_that_is_gone_has_decayed():
    time = times(100)
    noise = 1e-10 * np.random.default_rng(0).standard_normal(time.size)
    for y in (np.exp(-8 * time) * (signal(time) - 0.01) + noise, 1e-9 * signal(time), np.exp(-50 * time)):
        reading = read(time, y)
        assert reading.state == "decayed"
        assert reading.omega is None


@pytest.mark.parametrize("omega", [0.0, 40.0])
def test_a_signal_that_comes_to_rest_away_from_0_has_buckled(omega):
    time = times(100)
    reading = read(time, -0.3 + np.exp(-6 * time) * np.cos(omega * time))
    assert (reading.state, reading.A_tip, reading.omega) == ("buckled", None, None)
    assert abs(reading.y_tip + 0.3) <= reading.y_tip_error < 1e-6
    assert read(time, np.full(time.size, 0.3)).state == "buckled"


def test_what_is_still_on_its_way_has_not_buckled():
    time = times(100)
    for rate in (1e-6, 1e-2, 1.0):  # towards 0, however slowly
        assert read(time, 0.3 * np.exp(-rate * time)).state == "not finished"
        assert read(time, 1e-3 * np.exp(-rate * time)).state == "not finished"
    for rate in (0.5, 2.5):  # towards 0.3, from where it was more than 1e-3 of it away in the last quarter
        assert read(time, 0.3 - 0.29 * np.exp(-rate * time)).state == "not finished"
    assert read(time, 0.3 + 1e-4 * np.cos(OMEGA * time)).state == "settled"  # a small beat about 0.3
    for size in (1, 2, 3):  # a run that was interrupted at once
        assert read(time[:size], 0.3 + time[:size]).state == "not finished"


def test_a_signal_without_oscillation_or_too_short_for_a_frequency_says_so():
    time = times(100)
    assert read(time, 1 + time).A_tip is None
    assert read(time, 1 + time).state == "not finished"
    short = times(12)
    assert read(short, signal(short)).omega is None
    assert read(short, signal(short)).A_tip == pytest.approx(A, rel=1e-6)
