"""Branches of orbits through folds to their other end, coexistence with the straight rod, the commands."""

import json
import re
from dataclasses import replace

import numpy as np
import pytest

from rodwnl import branches, cli, coexistence
from rodwnl.branches import Branch, BranchPoint, branch
from rodwnl.coexistence import bistability, periodic_orbits, straight_is_stable
from rodwnl.continuation import ConvergenceError
from rodwnl.errors import ComputationError, InputError
from rodwnl.normalform import normal_form
from rodwnl.orbits import orbit_at
from rodwnl.parameters import RodParameters
from rodwnl.spectrum import HopfSearch, hopf_thresholds
from rodwnl.strainform import follower

STIFF = RodParameters(1e4, 1e4, 1e-4)
REENTRANT = RodParameters(160, "1e4", "1e-4")  # unstable between two thresholds, the upper one subcritical


@pytest.fixture(scope="module")
def search() -> HopfSearch:
    return hopf_thresholds(REENTRANT)


@pytest.fixture(scope="module")
def whole(search) -> Branch:
    """From the lower threshold to wherever it leads."""
    return branch(REENTRANT, search[0].force, search[0].omega)


def test_the_branch_joins_both_thresholds_through_a_fold(whole, search):
    assert whole.start.force == pytest.approx(search[0].force, rel=1e-11)
    assert whole.end == "Hopf point"
    assert whole.last.force == pytest.approx(search[1].force, rel=1e-9)
    assert whole.last.omega == pytest.approx(search[1].omega, rel=1e-9)
    (fold,) = whole.folds
    assert whole.events == whole.folds
    stable = [point.stable for point in whole.points]
    assert stable == [i < fold.index for i in range(len(stable))]
    forward = [point.forward > 0 for point in whole.points]
    assert forward == stable
    assert all(point.cycle.force < fold.force for point in whole.points)


def test_the_slopes_at_onset_are_those_of_the_amplitude_equation(whole, search):
    form = normal_form(follower(*REENTRANT.floats()), search[0].force, search[0].omega)
    ratio = form.beta.real / form.alpha.real
    assert whole.A_tip2_slope == pytest.approx(-4 * ratio, rel=1e-9)
    assert whole.omega_slope == pytest.approx(form.beta.imag - form.alpha.imag * ratio, rel=1e-9)
    first = whole.points[0].cycle
    gained = first.force - whole.start.force
    assert first.tip_amplitude**2 / gained == pytest.approx(whole.A_tip2_slope, rel=0.02)


def test_the_fold_is_a_fold(whole):
    """A multiplier is 1 there, two orbits exist just below it and none just above it."""
    (fold,) = whole.folds
    assert fold.error < 1e-6
    assert abs(fold.at.rho[0] - 1) < 1e-3
    below = periodic_orbits_on(whole, fold.force - 0.02)
    assert [orbit.stable for orbit in below] == [True, False]
    amplitudes = [orbit.A_tip for orbit in below]
    assert amplitudes[0] > fold.at.cycle.tip_amplitude > amplitudes[1]
    assert np.mean(amplitudes) == pytest.approx(fold.at.cycle.tip_amplitude, rel=1e-3)
    with pytest.raises(ComputationError):
        orbit_at(fold.at.cycle, fold.force + 0.02)


def periodic_orbits_on(whole: Branch, force: float):
    return sorted(coexistence._crossings(whole, force), key=lambda orbit: -orbit.A_tip)


def test_orbits_along_the_branch_are_the_refined_ones(whole):
    """What the coarser grids along the branch leave is below the stated 1e-6."""
    for point in whole.points[2::8]:
        fine = orbit_at(point.cycle, point.cycle.force)
        assert point.cycle.tip_amplitude == pytest.approx(fine.A_tip, rel=1e-6)
        assert point.cycle.omega == pytest.approx(fine.omega, rel=1e-6)
        assert fine.stable == point.stable


def test_straight_rod_and_orbit_are_both_stable_between_threshold_and_fold(whole, search, monkeypatch):
    monkeypatch.setattr(coexistence, "branch", lambda *args, **options: whole)
    found = bistability(REENTRANT)
    ((low, high),) = found.intervals
    assert low == pytest.approx(search[1].force, rel=1e-12)
    assert high == pytest.approx(whole.folds[0].force, rel=1e-12)
    assert len(found.branches) == 1  # the second threshold is the first one's end
    inside = periodic_orbits(REENTRANT, (low + high) / 2)
    assert inside.straight_stable
    assert [orbit.stable for orbit in inside.orbits] == [True, False]
    assert inside.branches == (whole,)
    with pytest.raises(ComputationError, match=r"at force 150, .* stable; .* nearest fold at 107\.045"):
        periodic_orbits(REENTRANT, 150)


def test_where_the_straight_rod_is_stable(search):
    inside = (search[0].force + search[1].force) / 2
    assert [straight_is_stable(search, force) for force in (1.0, inside, 159.0)] == [True, False, True]


def test_an_unstable_straight_rod_leads_to_its_orbit():
    found = periodic_orbits(RodParameters("1e4", "1e4", "1e-4"), 38)
    (orbit,) = found.orbits
    assert not found.straight_stable
    assert found.branches == ()
    assert orbit.stable
    assert orbit.A_tip == pytest.approx(0.1017655739, rel=1e-8)  # direct simulation gives 0.10177
    assert orbit.omega == pytest.approx(193.130415, rel=1e-8)


def test_far_from_onset_the_branch_is_followed_to_the_force():
    rod = RodParameters("1e4", "1e4", "1e-4")
    near, far = (periodic_orbits(rod, force).orbits[0] for force in (39, 43))
    assert far.A_tip > near.A_tip
    assert far.omega > near.omega


@pytest.mark.parametrize("force", [-1, 160, "200"])
def test_a_force_without_straight_rod_is_refused(force):
    with pytest.raises(InputError, match="exists only for 0 <= force < k1 = 160"):
        periodic_orbits(REENTRANT, force)


def test_a_branch_stops_where_it_is_told_to():
    until = branch(STIFF, 37.66, 191.2, until=38.25)
    assert (until.end, until.last.force) == ("force asked for", 38.25)
    assert until.points[-1].cycle.force == 38.25
    edge = branch(STIFF, 37.66, 191.2, window=(0.0, 38.25))
    assert (edge.end, edge.last.force) == ("edge of the range", 38.25)
    few = branch(STIFF, 37.66, 191.2, most_points=2)
    assert (few.end, len(few.points)) == ("number of points", 2)
    assert few.points[-1].cycle.tip_amplitude == pytest.approx(few.last.tip_amplitude)


def test_a_branch_takes_its_numbers_as_texts_and_refuses_others():
    few = branch(STIFF, "37.66", "191.2", until="38.25", locate_events=False)
    assert (few.end, few.last.force) == ("force asked for", 38.25)
    for arguments, name in ((("a", 191.2), "force"), ((37.66, -1), "omega"), ((37.66, 191.2, "x"), "until")):
        with pytest.raises(InputError, match=f"{name} is"):
            branch(STIFF, *arguments)


def test_a_subcritical_branch_begins_unstable_on_the_stable_side():
    few = branch(RodParameters(200.0, 1e4, 1e-4), 155.6, 3367.3, most_points=2)
    assert [point.unstable for point in few.points] == [1, 1]
    assert all(point.cycle.force > few.start.force for point in few.points)


@pytest.mark.parametrize(
    ("before", "after", "expected"),
    [
        ([0.9], [1.1], "branch point"),  # a fold would turn the tangent
        ([-0.9], [-1.1], "symmetry breaking"),
        ([0.6 + 0.7j, 0.6 - 0.7j], [0.8 + 0.7j, 0.8 - 0.7j], "torus"),
        ([0.9, 0.5], [0.95, 0.5], None),
    ],
)
def test_what_crosses_the_unit_circle_names_the_event(whole, monkeypatch, before, after, expected):
    named = []
    monkeypatch.setattr(branches, "_pinned", lambda kind, *rest: named.append(kind))
    start = whole.points[0]

    def with_rho(rho) -> BranchPoint:
        return replace(start, rho=np.array(rho, dtype=complex))

    branches._events(with_rho(before), 0.1, with_rho(after), 1)
    assert named == ([] if expected is None else [expected])


@pytest.mark.parametrize("model", ["follower", "metric_drag"])
def test_a_change_of_stability_is_located_to_its_accuracy(model):
    """A multiplier that passes through another size than 1: on these branches 1 is met at folds only."""
    rod = RodParameters(200, 1e4, 1e-4, model=model)
    points = branch(rod, 49.758, 446.0 if model == "metric_drag" else 334.3, until=52.0).points
    before, after = points[-2:]
    size = np.sqrt(np.abs(before.rho[0] * after.rho[0]))
    length = (after.cycle.force - before.cycle.force) / before.forward

    def event(at: BranchPoint) -> float:
        return float(np.log(np.abs(at.rho[0]) / size))

    found = branches._pinned("torus", before, length, after, event, 1)
    assert found.error < 1e-6
    assert before.cycle.force < found.force < after.cycle.force
    orbit = orbit_at(found.at.cycle, found.force + 1e-3)
    nearby = orbit_at(found.at.cycle, found.force - 1e-3)
    sizes = [np.sqrt(abs(o.multipliers[0])) for o in (nearby, orbit)]
    assert sizes[0] > size > sizes[1]
    slope = (sizes[1] - sizes[0]) / 2e-3
    assert abs(np.mean(sizes) - size) < 1e-6 * abs(slope) + 1e-8


ROD = ["--k1", "1e4", "--k2", "1e4", "--gamma3", "1e-4"]


def test_command_orbit(capsys):
    assert cli.run(["orbit", *ROD, "--force", "38", "--json"]) == 0
    document = json.loads(capsys.readouterr().out)
    assert document["orbit"] == document["orbits"][0]
    assert document["straight"] == "unstable"
    assert float(document["orbit"]["A_tip"]) == pytest.approx(0.1017655739, rel=1e-8)
    assert document["orbit"]["stable"] is True
    assert float(document["orbit"]["residual"]) < 1e-8
    assert cli.run(["orbit", *ROD, "--force", "38"]) == 0
    text = capsys.readouterr().out
    assert "0.10176557" in text
    assert "193.1304150" in text


def test_command_branch(capsys):
    assert cli.run(["branch", *ROD, "--until", "38.2", "--json"]) == 0
    document = json.loads(capsys.readouterr().out)
    assert document["end"] == {
        "reason": "force asked for",
        "force": "38.2",
        "omega": document["end"]["omega"],
    }
    assert document["folds"] == []
    forces = [float(point["force"]) for point in document["points"]]
    assert forces == sorted(forces)
    assert all(point["stable"] for point in document["points"])
    assert cli.run(["branch", *ROD, "--max-points", "2"]) == 0
    assert "The branch ends: this many points were asked for" in capsys.readouterr().out


def test_command_hysteresis(capsys, whole, monkeypatch):
    monkeypatch.setattr(coexistence, "branch", lambda *args, **options: whole)
    arguments = ["hysteresis", "--k1", "160", "--k2", "1e4", "--gamma3", "1e-4"]
    assert cli.run([*arguments, "--json"]) == 0
    document = json.loads(capsys.readouterr().out)
    (interval,) = document["intervals"]
    assert float(interval["high"]) == pytest.approx(whole.folds[0].force)
    assert cli.run(arguments) == 0
    text = capsys.readouterr().out
    assert "Both are stable between force = 104.353" in text
    assert "fold" in text
    assert cli.run(["hysteresis", "--k1", "140", "--k2", "1e4", "--gamma3", "1e-4"]) == 0
    nowhere = "Up to force = 140 the straight rod and a periodic orbit are nowhere both stable: no hysteresis"
    assert nowhere in capsys.readouterr().out


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["branch", *ROD, "--threshold", "2"], "threshold is 2, .* the rod has these: 1 at 37.656"),
        (["branch", *ROD, "--max-points", "0"], "max_points is 0, but a branch has at least one point"),
        (["branch", *ROD, "--until", "1e4"], "until is .*, but the straight rod exists only for"),
        (["orbit", *ROD, "--force", "nan"], "force is 'nan': not a finite number"),
        (["orbit", "--k1", "140", "--k2", "1e4", "--gamma3", "1e-4", "--force", "9"], "no Hopf threshold"),
    ],
)
def test_bad_requests_end_with_one_line(capsys, arguments, message):
    assert cli.run(arguments) == 2
    captured = capsys.readouterr()
    assert captured.out == ""
    (line,) = captured.err.splitlines()
    assert re.search(message, line)


def test_a_fold_next_to_a_hopf_point_is_seen_from_either_end():
    """k1 = 150.9: the fold lies 0.0066 beyond the upper threshold, within the branch's last step."""
    rod = RodParameters(150.9, 1e4, 1e-4)
    from_below = branch(rod, 66.029541, 590.180246)
    from_above = branch(rod, 87.863223, 1049.660273, most_points=6)
    assert from_below.end == "Hopf point"
    (fold,), (same,) = from_below.folds, from_above.folds
    assert fold.index == len(from_below.points)
    assert fold.force == pytest.approx(same.force, rel=1e-9)
    assert fold.force == pytest.approx(87.8698086052, abs=1e-7)
    # Stable up to the fold, unstable from there to the threshold.
    assert [stable for _, stable in from_below.path][-3:-1] == [True, False]


def test_an_event_that_cannot_be_refined_is_kept_with_its_error(monkeypatch):
    def fails(*_):
        raise ConvergenceError("no")

    monkeypatch.setattr(branches, "locate", fails)
    found = branch(RodParameters(150.9, 1e4, 1e-4), 87.863223, 1049.660273, most_points=6)
    (fold,) = found.folds
    assert len(found.points) == 6
    assert 1e-6 < abs(fold.force - 87.8698086052) < fold.error


def test_an_end_that_cannot_be_solved_for_keeps_the_points(monkeypatch):
    def fails(*_):
        raise ConvergenceError("no")

    monkeypatch.setattr(branches, "solve_at", fails)
    found = branch(STIFF, 37.66, 191.2, until=38.25)
    assert found.end == "not resolved"
    assert found.points
    assert found.last.force == pytest.approx(found.points[-1].cycle.force, rel=1e-12)
    assert found.last.force < 38.25
