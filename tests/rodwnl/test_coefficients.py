"""α, β and what follows from them: known answers, the exact route, error estimates, verdicts."""

from dataclasses import replace
from fractions import Fraction

import mpmath as mp
import numpy as np
import pytest

from rodwnl import ComputationError, RodParameters, hopf_thresholds, landau
from rodwnl.coefficients import landau_at
from rodwnl.exact import exact_threshold

REENTRANT = RodParameters(200, 10000, "1e-4")

# α and β of the paper's four rows to 20 digits, from a 45-digit evaluation with sums of exponentials
KNOWN = [
    ((10000, 10000, "1e-4"), 0, ("-971.75838247754807269", "29.070793841884010161"),
     ("7.3473106429252644120", "5.3618056412782265580")),
    ((10000, 100, "1e-2"), 0, ("-466.06795099003088758", "57.450368575353182325"),
     ("6.9268355639690712653", "4.1293081891661241936")),
    ((200, 10000, "1e-4"), 0, ("-2183.5610531835636856", "252.07427671518822549"),
     ("6.5967475565675326497", "9.1561669213649003733")),
    ((200, 10000, "1e-4"), 1, ("328900.63038756558418", "-307479.08049950980468"),
     ("-64.594629859758263520", "88.257513010602105182")),
]  # fmt: skip


def distance(value, exact):
    """|value − exact| for a complex double and the texts of two real numbers."""
    real, imag = Fraction(value.real) - Fraction(exact[0]), Fraction(value.imag) - Fraction(exact[1])
    return float(abs(complex(real, imag)))


@pytest.mark.parametrize(("rod", "index", "alpha", "beta"), KNOWN)
def test_the_papers_rows_hold_to_their_errors(rod, index, alpha, beta):
    found = landau(RodParameters(*rod))[index]
    assert distance(found.alpha, alpha) < found.alpha_error < 1e-11 * abs(found.alpha)
    assert distance(found.beta, beta) < found.beta_error < 1e-11 * abs(found.beta)
    assert sum(found.alpha_parts) == found.alpha
    assert sum(found.beta_parts) == found.beta
    assert max(found.residuals.values()) < 1e-12


def some_rods(number, high, seed):
    rng = np.random.default_rng(seed)
    low, high = np.log10([20, 5, 1e-8, 0.05]), np.log10([high, high, 1, 2])
    return [tuple(f"{10**x:.5g}" for x in rng.uniform(low, high)) for _ in range(number)]


def close_to_exact(rod, found, tolerance):
    exact = exact_threshold(rod, found.force, found.omega, 18)
    errors = {
        "force": found.threshold.force_error, "omega": found.threshold.omega_error,
        "alpha": found.alpha_error, "beta": found.beta_error,
        "A_tip2_slope": found.A_tip2_slope_error, "omega_slope": found.omega_slope_error,
    }  # fmt: skip
    for name, error in errors.items():
        value = getattr(found, name)
        assert abs(mp.mpmathify(value) - getattr(exact, name)) < error, name
    assert found.alpha_error < tolerance * abs(found.alpha)
    assert found.beta_error < tolerance * abs(found.beta)


@pytest.mark.parametrize("parameters", some_rods(6, 1e5, seed=3))
def test_moderate_rods_agree_with_the_exact_route(parameters):
    rod = RodParameters(*parameters)
    for found in landau(rod, min(rod.k1, 120)):
        close_to_exact(rod, found, 1e-9)


@pytest.mark.parametrize("parameters", some_rods(8, 1e8, seed=4))
def test_errors_are_honest_over_all_decades(parameters):
    rod = RodParameters(*parameters)
    for found in landau(rod, min(rod.k1, 120)):
        close_to_exact(rod, found, 1e-6)


def test_verdicts_and_slopes_of_the_reentrant_rod():
    lower, upper = landau(REENTRANT)
    assert (lower.criticality, lower.crossing) == ("supercritical", "destabilizing")
    assert (upper.criticality, upper.crossing) == ("subcritical", "restabilizing")
    for c in (lower, upper):
        assert c.A_tip2_slope == pytest.approx(-4 * c.beta.real / c.alpha.real, rel=1e-14)
        expected = c.beta.imag - c.alpha.imag * c.beta.real / c.alpha.real
        assert c.omega_slope == pytest.approx(expected, rel=1e-14)
        assert (c.force, c.omega) == (c.threshold.force, c.threshold.omega)


@pytest.mark.parametrize("change", [{"alpha_error": 1e4}, {"beta_error": 10.0}, {"alpha": 1j}, {"beta": 1j}])
def test_what_the_errors_do_not_exclude_is_called_degenerate(change):
    lower = landau(REENTRANT)[0]
    assert replace(lower, **change).criticality == "degenerate"


def test_near_the_merging_of_two_thresholds_the_errors_grow():
    far = landau(RodParameters(150, 10000, "1e-4"), escalate=False)
    near = landau(RodParameters("147.92152", 10000, "1e-4"), escalate=False)
    for a, b in zip(far, near, strict=True):
        assert b.threshold.force_error > 10 * a.threshold.force_error
        assert b.A_tip2_slope_error / abs(b.A_tip2_slope) > 10 * a.A_tip2_slope_error / abs(a.A_tip2_slope)
    for found in near:
        close_to_exact(near.rod, found, 1e-7)


def test_later_crossings_have_coefficients_too():
    rod = RodParameters(10000, 10000, "1e-4")
    (later,) = hopf_thresholds(rod, 200, all_crossings=True).later
    found = landau_at(rod, later)
    assert (found.threshold.unstable_below, found.threshold.unstable_above) == (2, 4)
    close_to_exact(rod, found, 1e-9)


def test_a_search_without_thresholds_has_no_coefficients():
    found = landau(RodParameters(20, 10000, "1e-4"))
    assert len(found) == 0
    assert found.search.range_cut
    assert found.rod == RodParameters(20, 10000, "1e-4")


@pytest.mark.parametrize(
    ("k2", "least", "most"),
    [("1e4", 12, 15), ("1e12", 4, 8), ("1e20", -3, 0)],
    ids=["moderate", "stiff", "lost"],
)
def test_a_rod_much_stiffer_in_shear_than_in_stretch_says_how_many_digits_it_loses(k2, least, most):
    found = landau(RodParameters(10000, k2, "1e-4"), escalate=False)[0]
    assert least < found.digits < most
    assert (found.criticality == "degenerate") == (found.digits < 0)


@pytest.mark.parametrize("parameters", [("1e4", "1e300", "1e-4"), ("1e-100", "1e4", "1e-4")])
def test_numbers_beyond_double_precision_are_refused(parameters):
    with pytest.raises(ComputationError, match="double precision"):
        landau(RodParameters(*parameters))
