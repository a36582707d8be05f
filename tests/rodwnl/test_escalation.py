"""Where double precision keeps fewer than eight digits the exact route takes over, or it is said."""

import json

import mpmath as mp
import pytest

from rodwnl import RodParameters, cli
from rodwnl import coefficients as module
from rodwnl.coefficients import DOUBLE, ENOUGH, landau
from rodwnl.errors import ComputationError
from rodwnl.exact import exact_threshold

# The parts of alpha cancel to seven digits: -2657720000 + 2657721000
HARD = RodParameters("180.8", "33810000", "0.0001672", "0.1392")
HARD_OPTIONS = ["landau", "--k1", "180.8", "--k2", "33810000", "--gamma3", "0.0001672", "--gamma1", "0.1392"]


def test_an_ill_conditioned_rod_is_computed_with_more_digits():
    kept, raised = landau(HARD, escalate=False)[1], landau(HARD)[1]
    assert kept.digits < ENOUGH <= raised.digits
    assert (kept.working_digits, raised.working_digits > DOUBLE) == (DOUBLE, True)
    exact = exact_threshold(HARD, raised.force, raised.omega, 25)
    with mp.workdps(40):
        for name, error in (
            ("alpha", "alpha_error"),
            ("beta", "beta_error"),
            ("omega_slope", "omega_slope_error"),
        ):
            assert abs(mp.mpmathify(getattr(raised, name)) - getattr(exact, name)) <= getattr(raised, error)
            assert abs(mp.mpmathify(getattr(kept, name)) - getattr(exact, name)) <= getattr(kept, error)
        assert abs(sum(exact.alpha_parts) - exact.alpha) < 1e-20 * abs(exact.alpha_parts[0])
    assert raised.alpha_error < 1e-6 * kept.alpha_error
    assert raised.criticality == kept.criticality == "supercritical"


def test_an_easy_rod_stays_in_double_precision():
    assert all(c.working_digits == DOUBLE for c in landau(RodParameters(200, "1e4", "1e-4")))


def test_modes_too_steep_for_quadrature_escalate_too(monkeypatch):
    rod = RodParameters("1e4", "1e2", "1e-2")
    (expected,) = landau(rod)

    def too_steep(*_):
        raise ComputationError("too steep")

    monkeypatch.setattr(module, "nodes_at", too_steep)
    (found,) = landau(rod)
    assert found.working_digits > DOUBLE
    assert found.alpha == pytest.approx(expected.alpha, rel=1e-9)
    assert found.alpha_parts == pytest.approx(expected.alpha_parts, rel=1e-9)
    assert found.beta_parts == pytest.approx(expected.beta_parts, rel=1e-9)
    with pytest.raises(ComputationError, match="too steep"):
        landau(rod, escalate=False)


def test_the_command_says_what_it_did(capsys):
    assert cli.run(HARD_OPTIONS) == 0
    assert "Threshold 2: double precision does not give 8 digits; " in capsys.readouterr().out
    assert cli.run([*HARD_OPTIONS, "--no-escalate"]) == 0
    assert "Threshold 2: only 7 digits hold" in capsys.readouterr().out
    assert cli.run([*HARD_OPTIONS, "--json"]) == 0
    assert json.loads(capsys.readouterr().out)["thresholds"][1]["working_digits"] > DOUBLE
