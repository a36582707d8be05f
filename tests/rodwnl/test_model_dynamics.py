"""Orbits and runs of rods other than the plain one, on their emitted laws."""

import json

import numpy as np
import pytest

from rodwnl import cli
from rodwnl.branches import branch
from rodwnl.coefficients import landau
from rodwnl.coexistence import periodic_orbits
from rodwnl.cycles import Rod
from rodwnl.emittedlaw import emitted_law
from rodwnl.errors import ComputationError, InputError
from rodwnl.laws import LAWS
from rodwnl.modelbranches import model_branch
from rodwnl.modelorbits import _solved, model_orbits, orbit_of
from rodwnl.modelsimulation import law_form
from rodwnl.nilpotent import exp, log, nilpotent
from rodwnl.normalform import _Discrete
from rodwnl.parameters import RodParameters
from rodwnl.predictions import predict
from rodwnl.simulation import simulate

SOFT = (200.0, 1e4, 1e-4)


@pytest.mark.parametrize("model", LAWS)
def test_emitted_laws_are_those_written_by_hand(model):
    """R and its exact first derivatives by state and force at a strained state."""
    rod = RodParameters(*SOFT, model=model)
    by_hand = LAWS[model](*SOFT, **{name: float(value) for name, value in rod.own})
    one, other = (_Discrete(law, 12) for law in (emitted_law(rod), by_hand))
    w = 0.1 * np.random.default_rng(3).standard_normal(one.size)
    w[-3] += 0.8
    pull = np.zeros_like(w), 1.0
    for found, expected in (
        (one.derivative(w, 30.0), other.derivative(w, 30.0)),
        (one.derivative(w, 30.0, pull), other.derivative(w, 30.0, pull)),
        (one.jacobian(w, 30.0), other.jacobian(w, 30.0)),
    ):
        np.testing.assert_allclose(found, expected, rtol=1e-12, atol=1e-12 * np.abs(expected).max())


def test_exponentials_and_logarithms_are_differentiated():
    """log(exp(f)) is f through the third derivative, and exp is its own."""
    x = nilpotent(0.7, (1, 1.0), (2, 2.0), (3, 3.0))
    same = log(exp(x * x))
    for directions in ((), (1,), (1, 2), (1, 2, 3)):
        assert same.part(*directions) == pytest.approx((x * x).part(*directions), abs=1e-13)
        assert exp(nilpotent(0.7, (1, 1.0), (2, 1.0), (3, 1.0))).part(*directions) == pytest.approx(
            np.exp(0.7)
        )


def test_the_plain_rods_orbit_comes_out_of_its_emitted_law():
    """Another set of equations and of unknowns: A_tip, ω, harmonics and multiplier of the plain route."""
    rod = RodParameters(1e4, 1e4, 1e-4)
    plain, found = periodic_orbits(rod, 40).orbits[0], model_orbits(rod, 40).orbits[0]
    assert found.A_tip == pytest.approx(plain.A_tip, rel=1e-8)
    assert found.omega == pytest.approx(plain.omega, rel=1e-8)
    assert found.harmonics[1] == pytest.approx(plain.harmonics[1], rel=1e-7)
    assert found.multipliers[0] == pytest.approx(plain.multipliers[0], rel=1e-6)
    assert found.stable
    assert plain.stable


@pytest.mark.parametrize(
    ("model", "values"),
    [("metric_drag", SOFT), ("quartic", SOFT), ("partial_follower", SOFT), ("distributed", (1e4, 1e4, 1e-4))],
)
def test_orbits_near_onset_are_those_predicted(model, values):
    """With half the detuning twice as close to the prediction of order 3, which leaves out the next."""
    rod = RodParameters(*values, model=model)
    threshold = predict(rod, 1)[0].coefficients.force

    def error(detuning: float) -> float:
        force = threshold * (1 + detuning)
        (orbit,), (prediction, *_) = model_orbits(rod, force).orbits, predict(rod, force)
        assert orbit.stable is prediction.stable is True
        assert max(orbit.error, orbit.residual, orbit.multiplier_error) < 1e-6
        return abs(orbit.A_tip / prediction.A_tip - 1) + abs(orbit.omega / prediction.omega - 1)

    assert error(1e-4) == pytest.approx(error(2e-4) / 2, rel=0.05)


def test_orbits_of_a_subcritical_threshold_are_unstable():
    rod = RodParameters(*SOFT, model="metric_drag")
    upper = predict(rod, "155.7")[1]
    assert upper.stable is False
    orbit = orbit_of(emitted_law(rod), upper)
    assert not orbit.stable
    assert abs(orbit.multipliers[0]) > 1
    assert orbit.A_tip == pytest.approx(upper.A_tip, rel=0.01)


def test_a_force_without_orbit_is_refused_in_one_line():
    rod = RodParameters(*SOFT, model="partial_follower")
    with pytest.raises(InputError, match=r"'partial_follower' has no orbit at force 1 .*branches lie above"):
        model_orbits(rod, 1)


def test_falling_back_to_the_straight_rod_is_recognised():
    """Below the threshold there is nothing else for Newton's method to find from an orbit above it."""
    rod = RodParameters(*SOFT, model="metric_drag")
    prediction = predict(rod, 50)[0]
    cycle = orbit_of(emitted_law(rod), prediction).cycle
    with pytest.raises(ComputationError, match=r"fell back to the straight rod at force 49\.6"):
        _solved(cycle.system, cycle.X, 49.6)


@pytest.mark.parametrize(
    ("model", "values", "force"),
    [
        ("metric_drag", SOFT, 52.0),
        ("quartic", SOFT, 54.0),
        ("partial_follower", SOFT, 46.0),
        ("distributed", (1e4, 1e4, 1e-4), 80.0),
    ],
)
def test_runs_end_on_the_orbit(model, values, force):
    """Two numerical methods that share only R: A_tip and ω of a run begun next to the orbit."""
    rod = RodParameters(*values, model=model)
    orbit = model_orbits(rod, force).orbits[0]
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
    with pytest.raises(InputError, match=r"made for the rod 'follower'.*`simulate` take any"):
        rod.require_plain("--reduced")


def test_the_command_prints_an_orbit_of_another_rod(capsys):
    values = ["--k1", "200", "--k2", "1e4", "--gamma3", "1e-4", "--model", "metric-drag"]
    assert cli.run(["orbit", *values, "--force", "50", "--json"]) == 0
    document = json.loads(capsys.readouterr().out)
    (orbit,) = model_orbits(RodParameters(*SOFT, model="metric_drag"), 50).orbits
    assert document["model"] == "metric_drag"
    assert document["straight"] == "unstable"
    assert float(document["orbit"]["A_tip"]) == pytest.approx(orbit.A_tip, rel=1e-9)
    assert document["orbit"]["stable"] is True
    assert cli.run(["orbit", *values, "--force", "20"]) == 2
    assert capsys.readouterr().err.count("\n") == 1


def test_the_plain_rods_branch_comes_out_of_its_emitted_law():
    rod = RodParameters(1e4, 1e4, 1e-4)
    start = landau(rod)[0]
    plain = branch(Rod(*rod.floats()), start.force, start.omega, until=40.0, locate_events=False)
    found = model_branch(emitted_law(rod), start, (0.0, 400.0), until=40.0)
    assert found.end == plain.end == "force asked for"
    one, other = found.points[-1], plain.points[-1]
    assert one.cycle.force == other.cycle.force == 40.0
    assert one.cycle.tip_amplitude == pytest.approx(other.cycle.tip_amplitude, rel=1e-6)
    assert one.cycle.omega == pytest.approx(other.cycle.omega, rel=1e-6)
    assert one.rho[0] == pytest.approx(other.rho[0], rel=1e-5)
    assert all(point.stable for point in found.points)
    assert not found.folds


def test_the_command_follows_another_rods_branch_through_its_fold(capsys):
    """Unstable from the upper threshold to the fold, the largest force, then stable down to the lower one."""
    values = ["--k1", "200", "--k2", "1e4", "--gamma3", "1e-4", "--model", "metric-drag"]
    assert cli.run(["branch", *values, "--threshold", "2", "--json"]) == 0
    document = json.loads(capsys.readouterr().out)
    (fold,) = document["folds"]
    force, points = float(fold["force"]), document["points"]
    fold_at = next(i for i, point in enumerate(points) if point["stable"])
    assert force == pytest.approx(161.4466394, abs=1e-6)
    assert float(fold["error"]["force"]) < 1e-6
    assert float(document["start"]["force"]) < force
    assert document["end"]["reason"] == "Hopf point"
    assert float(document["end"]["force"]) == pytest.approx(
        landau(RodParameters(*SOFT, model="metric_drag"))[0].force
    )
    assert all(float(point["force"]) < force for point in points)
    assert [point["stable"] for point in points] == [i >= fold_at for i in range(len(points))]
