"""A_tip(F) and ω(F): where the branch exists, whether it is stable, and its continuity at onset."""

from dataclasses import replace

import pytest

from rodwnl import InputError, RodParameters, landau, predict
from rodwnl.predictions import predict_at
from rodwnl.responses import amplitude_equation

REENTRANT = RodParameters(200, 10000, "1e-4")
ROD = RodParameters(10000, 10000, "1e-4")


def test_the_supercritical_branch_exists_above_its_threshold_and_is_stable():
    (prediction,) = predict(ROD, 38)
    assert (prediction.side, prediction.exists, prediction.stable) == ("above", True, True)
    c = prediction.coefficients
    detuning = 38 - c.force
    assert prediction.A_tip == pytest.approx((-4 * c.beta.real / c.alpha.real * detuning) ** 0.5, rel=1e-13)
    assert prediction.omega == pytest.approx(c.omega + c.omega_slope * detuning, rel=1e-13)
    assert 0 < prediction.A_tip_error < 1e-11
    assert 0 < prediction.omega_error < 1e-10


def test_on_the_other_side_there_is_no_branch():
    (prediction,) = predict(ROD, 37)
    assert (prediction.side, prediction.exists, prediction.stable) == ("above", False, None)
    assert prediction.A_tip is prediction.omega is prediction.A_tip_error is prediction.omega_error is None


def test_the_subcritical_branch_of_the_upper_threshold_lies_above_and_is_unstable():
    lower, upper = predict(REENTRANT, 156)
    assert (lower.exists, lower.stable) == (True, True)
    assert (upper.side, upper.exists, upper.stable) == ("above", True, False)


def test_amplitude_vanishes_like_a_square_root():
    c = landau(ROD)[0]
    near, far = predict_at(c, c.force + 1e-4), predict_at(c, c.force + 1e-2)
    assert far.A_tip / near.A_tip == pytest.approx(10, rel=1e-9)
    assert near.omega == pytest.approx(c.omega, abs=1e-3)


def test_the_errors_of_the_curvatures_are_in_those_of_the_prediction():
    c = landau(ROD)[0]
    beyond = amplitude_equation(ROD, c.threshold)
    known = predict_at(c, 38.0, replace(beyond, A_tip2_curvature_error=0.0, omega_curvature_error=0.0))
    rough = predict_at(c, 38.0, replace(beyond, A_tip2_curvature_error=1e-3, omega_curvature_error=2.0))
    squared = (38.0 - c.force) ** 2
    assert rough.omega_error - known.omega_error == pytest.approx(2 * squared, rel=1e-9)
    assert 2 * rough.A_tip * (rough.A_tip_error - known.A_tip_error) == pytest.approx(1e-3 * squared)


def test_a_degenerate_threshold_predicts_nothing():
    degenerate = replace(landau(ROD)[0], alpha_error=1e9)
    prediction = predict_at(degenerate, 38.0)
    assert (prediction.side, prediction.exists, prediction.A_tip) == (None, False, None)


def test_a_force_beyond_the_default_range_extends_the_search():
    (prediction,) = predict(RodParameters(10000, 10000, "1e-4"), 500)
    assert prediction.exists
    assert prediction.coefficients.force < 38


def test_a_stable_rod_has_no_predictions():
    assert predict(RodParameters(20, 10000, "1e-4"), 10) == ()


@pytest.mark.parametrize("force", [-1, 200, 1e9])
def test_a_force_that_the_straight_rod_cannot_bear_is_refused(force):
    with pytest.raises(InputError, match="force is"):
        predict(REENTRANT, force)
