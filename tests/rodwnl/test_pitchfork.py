"""Buckling under a dead load: the pitchfork's coefficients against computed equilibria and the elastica."""

import json

import mpmath as mp
import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.optimize import brentq

from rodwnl import InputError, RodParameters, cli, simulate
from rodwnl.collocated import leading_eigenvalues
from rodwnl.exact_pitchfork import exact_pitchfork
from rodwnl.predictions import buckled_at, predict_buckled
from rodwnl.responses import Pitchfork, amplitude_equation, pitchfork
from rodwnl.spectrum import HopfThreshold
from rodwnl.storage import load


def dead(k1, k2, gamma3="1e-3"):
    return RodParameters(k1, k2, gamma3, model="partial_follower", chi="0")


def buckling(rod):
    """Where the leading eigenvalue passes through 0."""

    def growth(force):
        return leading_eigenvalues(rod, np.array([force]), 4)[0][0, 0].real

    force = brentq(growth, 0.5, 4, xtol=1e-13)
    slope = complex(leading_eigenvalues(rod, np.array([force]), 4)[1][0, 0])
    return HopfThreshold(
        force,
        0.0,
        slope,
        unstable_below=0,
        unstable_above=1,
        residual=0.0,
        force_error=1e-12,
        omega_error=0.0,
    )


def equilibrium(rod, force):
    """Tip displacement of the buckled rod, from the statics: the internal force is (-F, 0) everywhere.

    F1 = -F cos(theta), F2 = F sin(theta), theta'' = h2 F1 - h1 F2, y' = h1 sin(theta) + h2 cos(theta).
    """
    k1, k2 = float(rod.k1), float(rod.k2)

    def rates(u, state):
        theta, slope, _ = state
        f1, f2 = -force * np.cos(theta), force * np.sin(theta)
        h1, h2 = 1 + f1 / k1, f2 / k2
        return [slope, h2 * f1 - h1 * f2, h1 * np.sin(theta) + h2 * np.cos(theta)]

    def shot(slope):
        return solve_ivp(rates, (0, 1), [0.0, slope, 0.0], rtol=1e-12, atol=1e-14).y[:, -1]

    slope = brentq(lambda s: shot(s)[1], 1e-3, 2.0, xtol=1e-14)
    return shot(slope)[2]


@pytest.mark.parametrize("rod", [dead("1e5", "1e5"), dead("60", "25"), dead("30", "400", "0.1")], ids=repr)
def test_buckled_states_are_computed_equilibria(rod):
    threshold = buckling(rod)
    form = pitchfork(rod, threshold)
    measured = [equilibrium(rod, threshold.force + d) ** 2 / d for d in (2e-3, 4e-3)]
    assert 2 * measured[0] - measured[1] == pytest.approx(form.y_tip2_slope, rel=2e-5)
    assert form.criticality == "supercritical"
    assert form.beta == pytest.approx(threshold.slope.real, rel=1e-9)


def test_of_a_stiff_rod_the_digits_are_those_of_the_elastica():
    # Tip angle t: F/F_c = 1 + t²/8, y(1) = 2t/π, F_c = π²/4 (Timoshenko & Gere, Elastic Stability, 2.7).
    found = exact_pitchfork(dead("1e30", "1e30"), 2.4674, 25)
    with mp.workdps(30):
        assert abs(found.force / (mp.pi**2 / 4) - 1) < mp.mpf(10) ** -24
        assert abs(found.y_tip2_slope / (128 / mp.pi**4) - 1) < mp.mpf(10) ** -24


@pytest.mark.parametrize("rod", [dead("60", "25"), dead("30", "400", "0.1")], ids=repr)
def test_digits_are_those_of_double_precision_and_of_more_digits(rod):
    threshold = buckling(rod)
    form, *exact = pitchfork(rod, threshold), *(exact_pitchfork(rod, threshold.force, n) for n in (20, 40))
    for name in ("alpha", "beta", "y_tip2_slope"):
        short, long = (getattr(found, name) for found in exact)
        assert mp.nstr(short, 20) == mp.nstr(long, 20)
        assert getattr(form, name) == pytest.approx(float(long), rel=1e-10)


def test_digits_of_a_rod_with_all_kinds_of_tip_loads(tmp_path, capsys):
    file = tmp_path / "rod.toml"
    file.write_text(
        """name = "tipped"
        energy = "k1*(h1 - 1)^2/2 + 30*k1*(h1 - 1)^4 + k2*h2^2/2 + Pi^2/2 + 5*Pi^4"
        drag = { v1 = "gamma1*sqrt(h1^2 + h2^2)", v2 = "sqrt(h1^2 + h2^2)", Omega = "gamma3" }
        load = [
            { kind = "follower", share = "1/5" }, { kind = "dead", share = "4/5" },
            { kind = "spring", stiffness = "2" }, { kind = "damper", drag = "1/10" },
            { kind = "drag", axial = "1/20", transverse = "1/7" },
        ]"""
    )
    entries = []
    for more in ([], ["--digits", "30"]):
        rod = ["--k1", "200", "--k2", "1e4", "--gamma3", "1e-4", "--max-force", "10"]
        assert cli.run(["landau", "--model", str(file), *rod, "--json", *more]) == 0
        entries += json.loads(capsys.readouterr().out)["steady"]
    double, exact = entries
    for name in ("force", "alpha", "beta", "y_tip2_slope"):
        assert float(double[name]) == pytest.approx(float(exact[name]), rel=1e-9)
        assert len(exact[name].lstrip("-0.").replace(".", "")) == 30
    assert double["criticality"] == exact["criticality"] == "supercritical"


def test_predicted_deflections_are_those_of_computed_equilibria():
    rod = dead("60", "25")
    (here,) = predict_buckled(rod, buckling(rod).force + 0.01)
    distance = here.force - here.threshold.force
    assert (here.side, here.exists, here.stable) == ("above", True, True)
    assert distance == pytest.approx(0.01)
    assert here.y_tip == pytest.approx(equilibrium(rod, here.force), rel=distance)
    assert 0 < here.y_tip_error < 1e-8 * here.y_tip
    (below,) = predict_buckled(rod, 2)
    assert (below.side, below.exists, below.stable, below.y_tip) == ("above", False, None, None)


@pytest.mark.parametrize(("distance", "duration"), [(0.02, 400), (0.2, 100)])
def test_a_run_comes_to_rest_at_the_computed_equilibrium(distance, duration):
    rod = dead("60", "25")
    force = buckling(rod).force + distance
    reading = simulate(rod, force, duration).reading
    assert (reading.state, reading.A_tip, reading.omega) == ("buckled", None, None)
    exact = equilibrium(rod, force)
    assert abs(reading.y_tip - exact) <= reading.y_tip_error + 1e-11 * exact  # the latter's own
    assert reading.y_tip_error < 1e-6 * exact
    (predicted,) = predict_buckled(rod, force)
    assert reading.y_tip == pytest.approx(predicted.y_tip, rel=distance)


def test_a_buckled_run_is_said_to_be_and_kept(capsys, tmp_path):
    arguments = ["--k1", "60", "--k2", "25", "--gamma3", "1e-3", "--model", "partial-follower", "--parameter"]
    path = tmp_path / "run.nc"
    run = ["simulate", *arguments, "chi=0", "--force", "2.6", "--time", "100"]
    assert cli.run([*run, "--out", str(path)]) == 0
    text = capsys.readouterr().out
    assert "The rod has buckled: its tip has come to rest away from the straight rod." in text
    assert cli.run([*run, "--check", "--json"]) == 0
    document = json.loads(capsys.readouterr().out)
    whole = document["simulation"]
    assert (whole["state"], whole["A_tip"]) == ("buckled", None)
    assert f"{float(whole['y_tip']):.8f}" in text
    finer, longer = (float(document[name]["y_tip"]) for name in ("finer", "twice_the_time"))
    assert finer == pytest.approx(longer, rel=1e-9)
    kept = load(path).attrs
    assert kept["state"] == "buckled"
    assert kept["y_tip"] == pytest.approx(float(whole["y_tip"]), rel=1e-9)
    assert kept["y_tip_error"] < 1e-6


def test_a_bent_state_beside_a_straight_one_that_is_stable_is_unstable():
    threshold = buckling(dead("60", "25"))
    backwards = Pitchfork(threshold.force, 4.0, 2.0, -0.5, 1e-9, 1e-9)
    bent = buckled_at(threshold, backwards, threshold.force - 0.1)
    assert (bent.side, bent.exists, bent.stable) == ("below", True, False)
    undecided = Pitchfork(threshold.force, 1e-12, 2.0, -2e12, 1e-9, 1e-9)
    assert buckled_at(threshold, undecided, 3.0).side is None


def test_a_stiff_rod_is_the_elastica():
    """Euler's load pi^2/4, and P/P_c = 1 + pi^2 y^2/32 beyond it (Timoshenko and Gere, section 2.7)."""
    rod = dead("1e8", "1e8")
    threshold = buckling(rod)
    euler = np.pi**2 / 4
    assert threshold.force == pytest.approx(euler, rel=1e-6)
    assert pitchfork(rod, threshold).y_tip2_slope == pytest.approx(32 / (np.pi**2 * euler), rel=1e-6)


def test_each_kind_of_threshold_has_its_own_equation():
    rod = dead("1e4", "1e4")
    threshold = buckling(rod)
    with pytest.raises(InputError, match="buckles"):
        amplitude_equation(rod, threshold)
    flutter = HopfThreshold(
        30.0,
        100.0,
        1 + 0j,
        unstable_below=0,
        unstable_above=2,
        residual=0.0,
        force_error=0.0,
        omega_error=0.0,
    )
    with pytest.raises(InputError, match="oscillates"):
        pitchfork(rod, flutter)
