"""The orders of the expansion, measured on periodic orbits of the full nonlinear rod."""

from itertools import pairwise

import numpy as np
import pytest

from rodwnl import RodParameters, amplitude_equation, branch, hopf_thresholds, periodic_orbits

STIFF = RodParameters("1e4", "1e4", "1e-4")
FORCES = (37.706, 37.756, 37.856)  # 0.05, 0.1 and 0.2 above the threshold


def orders(sizes, errors) -> list[float]:
    """p between neighbours where the errors are proportional to the p-th power of the sizes."""
    return [
        float(np.log(b[1] / a[1]) / np.log(b[0] / a[0]))
        for a, b in pairwise(zip(sizes, np.abs(errors), strict=True))
    ]


@pytest.fixture(scope="module")
def near_onset():
    """Order 5 at the threshold, distances δ = F − F_c from it, and the orbits there."""
    (threshold,) = hopf_thresholds(STIFF)
    found = [periodic_orbits(STIFF, force).orbits[0] for force in FORCES]
    distances = np.array([orbit.force for orbit in found]) - threshold.force
    return amplitude_equation(STIFF, threshold), distances, found


def test_amplitude_parts_from_the_orbit_with_a_power_that_the_order_sets(near_onset):
    """A_tip² = slope δ + O(δ²), so A_tip errs by δ^{3/2}; with the curvature by δ^{5/2}."""
    theory, distances, found = near_onset
    A_tip = np.array([orbit.A_tip for orbit in found])
    cubic = np.sqrt(theory.A_tip2_slope * distances)
    quintic = np.sqrt(theory.A_tip2_slope * distances + theory.A_tip2_curvature * distances**2)
    assert orders(distances, cubic - A_tip) == pytest.approx([1.5, 1.5], abs=0.1)
    assert orders(distances, quintic - A_tip) == pytest.approx([2.5, 2.5], abs=0.1)


def test_frequency_parts_from_the_orbit_with_a_power_that_the_order_sets(near_onset):
    """ω = ω_c + slope δ + O(δ²); with the curvature O(δ³)."""
    theory, distances, found = near_onset
    shift = np.array([orbit.omega for orbit in found]) - theory.omega
    cubic = theory.omega_slope * distances
    quintic = cubic + theory.omega_curvature * distances**2
    assert orders(distances, cubic - shift) == pytest.approx([2, 2], abs=0.1)
    assert orders(distances, quintic - shift) == pytest.approx([3, 3], abs=0.1)


def test_predicted_fold_is_asymptotic_at_the_bautin_point():
    """Force and amplitude of the fold: the relative errors are proportional to Re α as Re α → 0."""
    alphas, forces, amplitudes = [], [], []
    for k1 in ("150.9", "151.2"):
        rod = RodParameters(k1, "1e4", "1e-4")
        _, upper = hopf_thresholds(rod)
        theory = amplitude_equation(rod, upper)
        (fold,) = branch(rod, upper.force, upper.omega, most_points=4).folds
        assert theory.fold is not None
        alphas.append(theory.coefficients["c210"].real)
        forces.append((theory.fold.force - fold.force) / (fold.force - upper.force))
        amplitudes.append(theory.fold.A_tip / fold.at.cycle.tip_amplitude - 1)
    assert max(np.abs([*forces, *amplitudes])) < 0.02
    assert orders(alphas, forces) == pytest.approx([1], abs=0.2)
    assert orders(alphas, amplitudes) == pytest.approx([1], abs=0.2)
