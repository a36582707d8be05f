"""Orbits and runs of rods other than the plain one, on their emitted laws."""

import json
import re
from pathlib import Path

import numpy as np
import pytest

from rodwnl import cli, coexistence
from rodwnl.branches import branch
from rodwnl.coefficients import landau
from rodwnl.coexistence import _crossings, bistability, periodic_orbits, straight_is_stable
from rodwnl.emittedlaw import emitted_law
from rodwnl.errors import InputError
from rodwnl.laws import LAWS
from rodwnl.models import emitted
from rodwnl.modelsimulation import law_form
from rodwnl.nilpotent import exp, log, nilpotent
from rodwnl.normalform import DiscreteRod
from rodwnl.orbits import orbit_at
from rodwnl.parameters import RodParameters
from rodwnl.predictions import predict, predict_at
from rodwnl.reduced import reduced_model
from rodwnl.simulation import simulate
from rodwnl.spectrum import hopf_thresholds
from rodwnl.straightrod import straight_rod
from rodwnl.strainform import integrals

SOFT = (200.0, 1e4, 1e-4)
LOADED = str(Path(__file__).parents[2] / "examples" / "loaded.toml")


@pytest.mark.parametrize("model", LAWS)
def test_emitted_laws_are_those_written_by_hand(model):
    """R and its exact first derivatives by state and force at a strained state."""
    rod = RodParameters(*SOFT, model=model)
    by_hand = LAWS[model](*SOFT, **{name: float(value) for name, value in rod.own})
    one, other = (DiscreteRod(law, 12) for law in (emitted_law(rod), by_hand))
    w = 0.1 * np.random.default_rng(3).standard_normal(one.size)
    w[-3] += 0.8
    pull = np.zeros_like(w), 1.0
    for found, expected in (
        (one.derivative(w, 30.0), other.derivative(w, 30.0)),
        (one.derivative(w, 30.0, pull), other.derivative(w, 30.0, pull)),
        (one.jacobian(w, 30.0), other.jacobian(w, 30.0)),
    ):
        np.testing.assert_allclose(found, expected, rtol=1e-12, atol=1e-12 * np.abs(expected).max())


@pytest.mark.parametrize("force", [40.0, 57.635385877629808, 120.0])
def test_the_straight_rod_is_the_same_by_both_routes(force):
    """Newton's method at each place, and on slopes of the strains, whose rounding keeps its steps from 0."""
    rod = RodParameters(200, 1e2, 1e-2, model=emitted(LOADED), stretch4="1e4")
    form = law_form(rod, force, 64)
    x, _, _, F1 = form.fields(form.straight)
    nu, nu_u = straight_rod(rod, force).stretch(form.nodes)
    np.testing.assert_allclose(form.straight[:65], nu_u, rtol=1e-9)
    np.testing.assert_allclose(x, integrals(64).up @ nu, atol=1e-13)
    np.testing.assert_allclose(F1, force * (form.nodes - 1), atol=1e-10)


def test_exponentials_and_logarithms_are_differentiated():
    """log(exp(f)) is f through the third derivative, and exp is its own."""
    x = nilpotent(0.7, (1, 1.0), (2, 2.0), (3, 3.0))
    same = log(exp(x * x))
    for directions in ((), (1,), (1, 2), (1, 2, 3)):
        assert same.part(*directions) == pytest.approx((x * x).part(*directions), abs=1e-13)
        assert exp(nilpotent(0.7, (1, 1.0), (2, 1.0), (3, 1.0))).part(*directions) == pytest.approx(
            np.exp(0.7)
        )


@pytest.mark.parametrize(
    ("model", "values"),
    [
        *(("metric_drag", SOFT), ("quartic", SOFT), ("partial_follower", SOFT)),
        *(("distributed", (1e4, 1e4, 1e-4)), (LOADED, (200, 1e2, 1e-2))),
    ],
)
def test_orbits_near_onset_are_those_predicted(model, values):
    """With half the detuning twice as close to the prediction of order 3, which leaves out the next."""
    rod = RodParameters(*values, model=emitted(model))
    threshold = predict(rod, 1)[0].coefficients.force

    def error(detuning: float) -> float:
        force = threshold * (1 + detuning)
        (orbit,), (prediction, *_) = periodic_orbits(rod, force).orbits, predict(rod, force)
        assert orbit.stable is prediction.stable is True
        assert max(orbit.error, orbit.residual, orbit.multiplier_error) < 1e-6
        return abs(orbit.A_tip / prediction.A_tip - 1) + abs(orbit.omega / prediction.omega - 1)

    assert error(1e-4) == pytest.approx(error(2e-4) / 2, rel=0.05)


def test_a_subcritical_branch_begins_unstable_as_predicted():
    rod = RodParameters(*SOFT, model="metric_drag")
    upper = predict(rod, "155.7")[1]
    c = upper.coefficients
    found = branch(rod, c.force, c.omega, until=155.7)
    orbit = orbit_at(found.last, 155.7)
    assert found.A_tip2_slope == pytest.approx(c.A_tip2_slope, rel=1e-8)
    assert found.omega_slope == pytest.approx(c.omega_slope, rel=1e-8)
    assert upper.stable is orbit.stable is False
    assert abs(orbit.multipliers[0]) > 1
    assert orbit.A_tip == pytest.approx(upper.A_tip, rel=0.01)


@pytest.mark.parametrize(
    ("model", "values", "force"),
    [
        ("metric_drag", SOFT, 52.0),
        ("quartic", SOFT, 54.0),
        ("partial_follower", SOFT, 46.0),
        ("distributed", (1e4, 1e4, 1e-4), 80.0),
        (LOADED, (200, 1e2, 1e-2), 63.0),
    ],
)
def test_runs_end_on_the_orbit(model, values, force):
    """Two numerical methods that share only R: A_tip and ω of a run begun next to the orbit."""
    rod = RodParameters(*values, model=emitted(model))
    orbit = periodic_orbits(rod, force).orbits[0]
    # d ln A/dt towards the orbit; the first half of the run leaves less than 1e-5 of the distance to it
    rate = -np.log(abs(orbit.multipliers[0])) * orbit.omega / (2 * np.pi)
    duration = max(2 * 12 / rate, 40 * 2 * np.pi / orbit.omega)
    run = simulate(rod, force, duration, orbit.A_tip, rtol=1e-6)
    assert run.resolved
    assert run.tip_residual < 1e-6
    assert run.reading.state == "settled"
    assert run.reading.A_tip == pytest.approx(orbit.A_tip, rel=1e-5)
    assert run.reading.omega == pytest.approx(orbit.omega, rel=1e-5)


@pytest.mark.parametrize("model", ["metric_drag", "distributed"])
def test_runs_start_at_rest_on_the_straight_rod(model):
    """Without a perturbation nothing moves; with one, clamp and tip are obeyed and y, θ are the sines."""
    form = law_form(RodParameters(*SOFT, model=model), 40.0, 20)
    rest, moving = (np.abs(form.rate(form.perturbed(size))).max() for size in (0.0, 1e-3))
    assert rest < 1e-9 * moving
    state, wave = form.perturbed(1e-3), 1e-3 * np.sin(np.pi / 2 * form.nodes)
    _, y, theta, _ = form.fields(state)
    np.testing.assert_allclose(theta, wave, atol=1e-5)
    np.testing.assert_allclose(y, wave, atol=1e-5)
    assert np.abs(form.rod.derivative(state, 40.0)[form.algebraic]).max() < 1e-3
    rows, rate = form.rod.jacobian(state, 40.0)[form.algebraic], form.rate(state)
    assert (np.abs(rows @ rate) <= 1e-12 * (np.abs(rows) @ np.abs(rate))).all()


def test_what_is_made_for_the_plain_rod_refuses_others():
    rod = RodParameters(*SOFT, model="quartic")
    with pytest.raises(InputError, match=r"made for the rod 'follower'.*not for 'quartic'"):
        rod.require_plain("--digits")


def test_the_command_prints_an_orbit_of_another_rod(capsys):
    values = ["--k1", "200", "--k2", "1e4", "--gamma3", "1e-4", "--model", "metric-drag"]
    assert cli.run(["orbit", *values, "--force", "50", "--json"]) == 0
    document = json.loads(capsys.readouterr().out)
    (orbit,) = periodic_orbits(RodParameters(*SOFT, model="metric_drag"), 50).orbits
    assert document["model"] == "metric_drag"
    assert document["straight"] == "unstable"
    assert float(document["orbit"]["A_tip"]) == pytest.approx(orbit.A_tip, rel=1e-9)
    assert document["orbit"]["stable"] is True
    assert cli.run(["orbit", *values, "--force", "200"]) == 2
    error = capsys.readouterr().err
    assert "no straight state" in error or "must have positive length" in error
    assert error.count("\n") == 1


def test_the_command_follows_another_rods_branch_through_its_fold(capsys):
    """Unstable from the upper threshold to the fold, the largest force, then stable."""
    values = ["--k1", "200", "--k2", "1e4", "--gamma3", "1e-4", "--model", "metric-drag"]
    assert cli.run(["branch", *values, "--threshold", "2", "--max-points", "10", "--json"]) == 0
    document = json.loads(capsys.readouterr().out)
    (fold,) = document["folds"]
    force, points = float(fold["force"]), document["points"]
    fold_at = next(i for i, point in enumerate(points) if point["stable"])
    assert force == pytest.approx(161.4466394, abs=1e-6)
    assert float(fold["error"]["force"]) < 1e-6
    assert float(document["start"]["force"]) < force
    assert document["end"]["reason"] == "number of points"
    assert all(float(point["force"]) < force for point in points)
    assert [point["stable"] for point in points] == [i >= fold_at for i in range(len(points))]


TIP_DRAG = """
name = "tip_drag"
title = "rod with a damper and drag at its tip"
energy = "k1*(h1 - 1)^2/2 + k2*h2^2/2 + Pi^2/2"

[parameters]
damper = { default = "1/1000", meaning = "damper at the tip" }

[drag]
v1 = "gamma1"
v2 = "1"
Omega = "gamma3"

[[load]]
kind = "follower"

[[load]]
kind = "damper"
drag = "damper"

[[load]]
kind = "drag"
axial = "1/50"
transverse = "1/50"
"""


@pytest.fixture(scope="module")
def dragged(tmp_path_factory) -> RodParameters:
    """A rod whose tip conditions hold velocities, from a file."""
    file = tmp_path_factory.mktemp("rod") / "rod.toml"
    file.write_text(TIP_DRAG, encoding="utf-8")
    return RodParameters(*SOFT, model=emitted(str(file)))


def test_drag_in_the_tip_conditions_orbit_prediction_and_run_agree(dragged):
    """At onset orbit and prediction agree to first order in the detuning; a run ends on the orbit."""
    c = landau(dragged)[0]

    def gaps(detuning: float) -> np.ndarray:
        force = c.force * (1 + detuning)
        (orbit,), prediction = periodic_orbits(dragged, force).orbits, predict_at(c, force)
        assert orbit.stable is prediction.stable is True
        return np.array([orbit.A_tip / prediction.A_tip - 1, orbit.omega / prediction.omega - 1])

    reduced, A = reduced_model(dragged, c.force, c), 0.003 - 0.002j
    y, theta = 2 * (A * reduced.Y).real, 2 * (A * reduced.Theta).real
    assert reduced.amplitude(y, theta) == pytest.approx(A, rel=1e-9)  # the conjugate mode does not count
    # A_tip with the detuning, ω with its square
    np.testing.assert_allclose(gaps(2e-4) / gaps(1e-4), [2, 4], rtol=0.05)
    force = c.force * 1.05
    orbit = periodic_orbits(dragged, force).orbits[0]
    rate = -np.log(abs(orbit.multipliers[0])) * orbit.omega / (2 * np.pi)
    run = simulate(dragged, force, max(24 / rate, 40 * 2 * np.pi / orbit.omega), orbit.A_tip, rtol=1e-6)
    assert run.resolved
    assert run.reading.state == "settled"
    assert run.reading.A_tip == pytest.approx(orbit.A_tip, rel=1e-5)
    assert run.reading.omega == pytest.approx(orbit.omega, rel=1e-5)


@pytest.fixture(scope="module")
def reentrant():
    """The branches of the metric-drag rod at the paper's reentrant parameters, and the intervals."""
    return bistability(RodParameters(*SOFT, model="metric_drag"))


def test_hysteresis_of_another_rod_lies_between_threshold_and_fold(reentrant):
    """Inside are a stable and an unstable orbit, beyond the fold none."""
    _, upper = reentrant.search
    (one,) = reentrant.branches
    (fold,) = one.folds
    assert reentrant.intervals == ((upper.force, fold.force),)
    assert one.end == "Hopf point"
    assert one.last.force == pytest.approx(upper.force, rel=1e-9)
    assert abs(fold.at.rho[0] - 1) < 1e-3
    assert fold.force == pytest.approx(161.4466394, abs=1e-6)
    inside = _crossings(one, (upper.force + fold.force) / 2)
    assert [orbit.stable for orbit in sorted(inside, key=lambda orbit: -orbit.A_tip)] == [True, False]
    assert not _crossings(one, fold.force + 0.1)
    assert [p.stable for p in one.points] == [i < fold.index for i in range(len(one.points))]


def test_the_command_says_where_another_rod_has_hysteresis(reentrant, capsys, monkeypatch):
    monkeypatch.setattr(coexistence, "bistability", lambda *given: reentrant)
    values = ["--k1", "200", "--k2", "1e4", "--gamma3", "1e-4", "--model", "metric-drag"]
    assert cli.run(["hysteresis", *values, "--json"]) == 0
    document = json.loads(capsys.readouterr().out)
    assert document["model"] == "metric_drag"
    ((low, high),) = reentrant.intervals
    assert document["intervals"] == [{"low": repr(low), "high": repr(high)}]
    assert document["branches"][0]["folds"][0]["kind"] == "fold"
    assert cli.run(["hysteresis", *values]) == 0
    assert "Both are stable between force = 155.600159 and 161.446639" in capsys.readouterr().out


def test_a_rod_that_only_beats_has_no_hysteresis():
    rod = RodParameters(*SOFT, model="quartic", bend4="1/1000", stretch4=0)
    found = bistability(rod, 51)
    assert found.intervals == ()
    assert [one.end for one in found.branches] == ["edge of the range"]


def test_a_buckled_straight_rod_is_not_stable():
    """A dead load buckles the rod; no oscillation begins, and no interval is called stable beyond."""
    rod = RodParameters(1e4, 1e4, 1e-4, model="partial_follower", chi=0)
    search = hopf_thresholds(rod, 30)
    (buckling, *_) = search.steady
    assert straight_is_stable(search, buckling.force - 0.1)
    assert not straight_is_stable(search, buckling.force + 0.1)


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["hysteresis", "--model", "nosuch"], "there is no rod 'nosuch'"),
        (["hysteresis", "--model", "quartic", "--max-force", "-1"], "searched from 0 upwards"),
        (["hysteresis", "--model", "quartic", "--parameter", "chi=1"], "has no parameter 'chi'"),
        (["simulate", "--model", "distributed", "--reduced", "--force", "300"], "stretch"),
        (["orbit", "--model", "metric-drag", "--force", "x"], "force is 'x': not a finite number"),
    ],
)
def test_bad_requests_for_another_rod_end_with_one_line(capsys, arguments, message):
    assert cli.run([*arguments, "--k1", "200", "--k2", "1e4", "--gamma3", "1e-4"]) == 2
    captured = capsys.readouterr()
    assert captured.out == ""
    (line,) = captured.err.splitlines()
    assert re.search(message, line)
