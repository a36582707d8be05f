"""Thresholds: known answers, completeness, and what is refused."""

from fractions import Fraction
from itertools import pairwise

import mpmath as mp
import numpy as np
import pytest

from rodwnl import ComputationError, InputError, RodParameters, hopf_thresholds, scan, spectrum
from rodwnl.balls import BallNumbers, flint, working_bits
from rodwnl.exact import refine_threshold
from rodwnl.halfplane import count_right_of, unstable_region
from rodwnl.inverse import inverse_operator, leading_eigenvalues
from rodwnl.linearrod import linear_rod
from rodwnl.parameters import exact
from rodwnl.quadrature import gauss_legendre

# F_c and ω_c of the paper's four rows to 20 digits, from a 45-digit evaluation of the determinant
KNOWN = {
    (10000, 10000, "1e-4"): [("37.655980545271066852", "191.20920923124324328")],
    (10000, 100, "1e-2"): [("27.427194126759281169", "113.54760786498526304")],
    (200, 10000, "1e-4"): [
        ("49.758004916191500361", "334.32146573770333928"),
        ("155.60015929879066643", "3367.2809575968312384"),
    ],
}


@pytest.mark.parametrize("rod", KNOWN)
def test_thresholds_of_the_papers_rods_hold_to_their_errors(rod):
    found = hopf_thresholds(RodParameters(*rod))
    assert len(found) == len(KNOWN[rod])
    for threshold, (force, omega) in zip(found, KNOWN[rod], strict=True):
        assert abs(Fraction(threshold.force) - Fraction(force)) < threshold.force_error < 1e-14 * float(force)
        assert abs(Fraction(threshold.omega) - Fraction(omega)) < threshold.omega_error < 1e-14 * float(omega)
        assert threshold.residual < 1e-14
        assert threshold.leading


def test_the_reentrant_rod_gains_and_loses_a_pair():
    lower, upper = hopf_thresholds(RodParameters(200, 10000, "1e-4"))
    assert (lower.crossing, lower.unstable_below, lower.unstable_above) == ("destabilizing", 0, 2)
    assert (upper.crossing, upper.unstable_below, upper.unstable_above) == ("restabilizing", 2, 0)
    assert lower.slope.real > 0 > upper.slope.real


def test_a_window_narrower_than_the_first_intervals_by_a_factor_of_a_million_is_seen():
    # The two thresholds of k2 = 1e4, gamma3 = 1e-4 merge near k1 = 147.9215196833.
    open_, shut = RodParameters("147.9215196849", 10000, "1e-4"), RodParameters("147.9215196", 10000, "1e-4")
    lower, upper = hopf_thresholds(open_)
    assert 0 < upper.force - lower.force < 1e-3
    assert (upper.force - lower.force) > 100 * (lower.force_error + upper.force_error)
    assert not hopf_thresholds(shut).thresholds


def test_the_width_of_the_window_closes_like_a_square_root():
    widths = []
    for excess in ("1e-2", "1e-4", "1e-6"):
        k1 = Fraction("147.9215196833") + Fraction(excess)
        lower, upper = hopf_thresholds(RodParameters(k1, 10000, "1e-4"))
        widths.append(upper.force - lower.force)
    assert np.log10(np.array(widths)[:-1] / np.array(widths)[1:]) == pytest.approx([1, 1], abs=1e-3)


def test_a_window_too_narrow_to_resolve_is_reported_and_not_passed_over(monkeypatch):
    monkeypatch.setattr(scan, "NARROWEST", 1e-4)  # the window is 3e-6 of the range
    with pytest.raises(ComputationError, match=r"near F = 75\.\d+ double precision cannot tell"):
        hopf_thresholds(RodParameters("147.9215196849", 10000, "1e-4"))


def brute_force_counts(parameters, forces, count=48):
    inverse = np.linalg.eigvals(inverse_operator(parameters, forces, count))
    leading = np.take_along_axis(inverse, np.argsort(-abs(inverse), axis=1)[:, :count], 1)
    return np.sum(leading.real > 0, axis=1)


def some_rods(number):
    rng = np.random.default_rng(20)
    low, high = np.log10([30, 60, 1e-8, 0.05]), np.log10([450, 1e6, 1, 2])
    return [tuple(float(f"{10**x:.6g}") for x in rng.uniform(low, high)) for _ in range(number)]


@pytest.mark.parametrize("parameters", some_rods(6))
def test_the_crossings_explain_every_count_on_a_fine_grid(parameters):
    search = hopf_thresholds(RodParameters(*parameters), all_crossings=True)
    forces = np.linspace(0, float(search.max_force), 100)
    explained = np.zeros(len(forces))
    for t in (*search.thresholds, *search.later):
        explained += np.where(forces > t.force, t.unstable_above - t.unstable_below, 0)
    assert np.array_equal(explained, brute_force_counts(parameters, forces))
    alone = hopf_thresholds(RodParameters(*parameters))
    assert [t.force for t in alone] == pytest.approx([t.force for t in search], rel=1e-12)
    assert alone.later is None


def test_later_crossings_are_those_of_a_rod_that_is_already_unstable():
    search = hopf_thresholds(RodParameters(10000, 100, "1e-2"), all_crossings=True)
    assert [(t.unstable_below, t.unstable_above) for t in search] == [(0, 2)]
    assert [t.unstable_below for t in search.later] == [2, 4, 6, 8, 10]
    assert not any(t.leading for t in search.later)


def test_a_short_rod_is_stable_up_to_the_force_that_compresses_it_to_nothing():
    search = hopf_thresholds(RodParameters(20, 10000, "1e-4"))
    assert search.thresholds == ()
    assert search.range_cut
    assert search.max_force == 20
    assert 0 <= search.growth_force <= 20
    assert -13 < search.growth < 0


def test_a_rod_that_stays_stable_is_told_how_close_it_comes():
    rod = RodParameters("147.5", 10000, "1e-4")  # its thresholds merged at k1 = 147.92, near F = 75.4
    search = hopf_thresholds(rod)
    grid = np.linspace(74, 77, 301)
    growth = leading_eigenvalues(rod.floats(), grid)[0].real.max(axis=1)
    assert search.growth_force == pytest.approx(grid[np.argmax(growth)], abs=0.2)
    assert search.growth == pytest.approx(growth.max(), abs=2e-2)


@pytest.mark.parametrize(
    ("asked", "searched", "cut", "thresholds"),
    [
        (None, 200, True, 2),
        ("1e3", 200, True, 2),
        (100, 100, False, 1),
        (0.1, Fraction(1, 10), False, 0),
        (0, 0, False, 0),
    ],
)
def test_the_range_searched_is_the_range_asked_for_cut_at_k1(asked, searched, cut, thresholds):
    search = hopf_thresholds(RodParameters(200, 10000, "1e-4"), asked)
    assert (search.max_force, search.range_cut, len(search)) == (searched, cut, thresholds)


def test_the_default_range_ends_at_400():
    search = hopf_thresholds(RodParameters(10000, 10000, "1e-4"))
    assert (search.max_force, search.range_cut) == (400, False)


@pytest.mark.parametrize(("k1", "k2", "gamma3", "number"), [(20, 5, "1e-4", 1), (200, 5, "1", 14)])
def test_the_crossings_of_a_soft_rod_are_all_there(k1, k2, gamma3, number):
    rod = RodParameters(k1, k2, gamma3)
    search = hopf_thresholds(rod, all_crossings=True)
    crossings = (*search.thresholds, *search.later)
    assert len(crossings) == number
    with mp.workdps(30):
        for t in crossings[:: max(1, number // 4)]:  # and the exact route has each of them
            force, omega = refine_threshold(rod, mp.mpf(t.force), mp.mpf(t.omega))
            assert abs(force - t.force) <= max(10 * t.force_error, 1e-12 * t.force)
            assert abs(omega - t.omega) <= max(10 * t.omega_error, 1e-12 * t.omega)


@pytest.mark.parametrize(
    ("parameters", "force", "omega"),
    [((1e3, 5.0, 1e-4, 0.5), 350.82, 3928.1), ((1e6, 5.0, 1.0, 0.5), 388.31, 721.7)],
)
def test_short_waves_do_not_spoil_the_slopes_of_the_determinant(parameters, force, omega):
    """The modes go like exp(160 i u) and exp(175 i u) here, and D through many waves as the force changes."""
    found = spectrum.Exponentials(parameters).threshold(force - 1, force + 1, force, omega)
    eigenvalues, slopes = (row[0] for row in leading_eigenvalues(parameters, np.array([found.force]), 60))
    at = np.argmin(abs(eigenvalues - 1j * found.omega))
    assert eigenvalues[at] == pytest.approx(1j * found.omega, rel=1e-7)
    assert found.slope == pytest.approx(slopes[at], rel=1e-6)


@pytest.mark.parametrize(("k1", "k2", "gamma3"), [(200, 5, "1"), (1000, 20, "1e-4")])
def test_between_the_crossings_of_a_soft_rod_the_proved_counts_are_those_seen(k1, k2, gamma3):
    pytest.importorskip("flint")
    rod = RodParameters(k1, k2, gamma3)
    search = hopf_thresholds(rod, all_crossings=True)
    crossings = (*search.thresholds, *search.later)
    with working_bits(128):
        for t, following in list(pairwise(crossings))[:3]:
            ball = linear_rod(rod, BallNumbers().number(exact("force", (t.force + following.force) / 2)))
            region = unstable_region(ball, flint().arb(0))
            assert count_right_of(ball, flint().arb(0), region) == t.unstable_above


def test_more_unstable_eigenvalues_than_can_be_followed_are_reported(monkeypatch):
    monkeypatch.setattr(scan, "MOST_KEPT", 60)
    rod = RodParameters(1000, 5, "1e-4")
    with pytest.raises(
        ComputationError, match=r"at F = 400 the rod has 56 unstable eigenvalues, and only 2\d"
    ):
        hopf_thresholds(rod, all_crossings=True)
    assert len(hopf_thresholds(rod)) == 1


def test_a_negative_range_is_refused():
    with pytest.raises(InputError, match=r"max_force is -1, but a follower force is searched from 0 upwards"):
        hopf_thresholds(RodParameters(200, 10000, "1e-4"), -1)


def test_shear_waves_too_short_for_the_operator_are_refused():
    with pytest.raises(ComputationError, match=r"wave number 337: 192 nodes would be needed, more than 160"):
        hopf_thresholds(RodParameters("1e8", 5, 1), 2000)


def test_a_crossing_that_the_scan_did_not_see_is_reported(monkeypatch):
    def forgetful(*arguments):
        samples, crossings, touches = scan.scan(*arguments)
        return samples, sorted(crossings)[1:], touches

    monkeypatch.setattr(spectrum, "scan", forgetful)
    with pytest.raises(ComputationError, match="one was missed"):
        hopf_thresholds(RodParameters(200, 10000, "1e-4"))
    with pytest.raises(ComputationError, match="one was missed"):
        hopf_thresholds(RodParameters(10000, 10000, "1e-4"))


@pytest.mark.parametrize(
    "parameters", [(1e4, 1e2, 1e-2, 0.5), (1e8, 5.0, 1.0, 0.5), (300.0, 20.0, 1e-4, 2.0)]
)
def test_leading_eigenvalues_do_not_depend_on_the_number_of_nodes(parameters):
    forces = np.array([5.0, 50.0, 250.0])
    coarse, _ = leading_eigenvalues(parameters, forces, 6)
    fine, _ = leading_eigenvalues(parameters, forces, 75)
    assert np.max(abs(coarse[:, :4] - fine[:, :4]) / abs(fine[:, :4])) < 1e-6


def test_quadrature_is_exact_for_polynomials():
    nodes = gauss_legendre(9)
    for degree in range(18):
        assert nodes.weights @ nodes.u**degree == pytest.approx(1 / (degree + 1), rel=1e-14)
    for degree in range(9):
        risen = nodes.u ** (degree + 1) / (degree + 1)
        assert nodes.from_clamp @ nodes.u**degree == pytest.approx(risen, rel=1e-12)
        assert nodes.to_tip @ nodes.u**degree == pytest.approx(1 / (degree + 1) - risen, rel=1e-12)
