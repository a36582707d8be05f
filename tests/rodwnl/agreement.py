"""A batch against the route of a single rod: used for the plain rod and for others."""

import pytest

NUMBERS = ("force", "omega", "alpha", "beta", "A_tip2_slope", "omega_slope")


def assert_same_numbers(found, i, expected, rod):
    """Rod number i of `landau_batch` has the thresholds and coefficients that `landau` found for it."""
    for j, c in enumerate(expected):
        # beyond 1e-9 only where the single rod's own error estimate is larger
        tolerance = max(1e-9, c.alpha_error / abs(c.alpha), c.A_tip2_slope_error / abs(c.A_tip2_slope))
        for name in NUMBERS:
            assert getattr(found, name)[i, j] == pytest.approx(getattr(c, name), rel=tolerance), (name, rod)
        assert (found.crossing[i, j] > 0) == (c.crossing == "destabilizing")
