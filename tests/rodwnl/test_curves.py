import json

import mpmath as mp
import numpy as np
import pytest

from rodwnl import RodParameters, cli, curves, hopf_thresholds, landau, landau_batch
from rodwnl.batch_coefficients import Coefficients
from rodwnl.continuation import ConvergenceError
from rodwnl.curves import SpecialPoint, equations, special_curve, special_point, threshold_curve
from rodwnl.errors import ComputationError
from rodwnl.exact import exact_threshold, refine_threshold

ROD = RodParameters(200, 1e4, 1e-4)


@pytest.fixture(scope="module")
def upper():
    """The curve of the upper threshold as k1 falls from 200, and its special points."""
    t = hopf_thresholds(ROD)[1]
    return threshold_curve(ROD, "k1", (t.force, t.omega), 140.0)


def test_curve_turns_around_and_comes_back_on_the_lower_threshold(upper):
    curve, _ = upper
    lower, start = landau(ROD)
    assert curve.end == "k1 is 200"
    assert (curve.force[0], curve.force[-1]) == pytest.approx((start.force, lower.force), rel=1e-10)
    assert (curve.omega[0], curve.omega[-1]) == pytest.approx((start.omega, lower.omega), rel=1e-10)
    assert (curve.alpha[0], curve.alpha[-1]) == (
        pytest.approx(start.alpha, rel=1e-9), pytest.approx(lower.alpha, rel=1e-9)
    )  # fmt: skip
    assert curve.rods["k1"].min() < 148
    assert np.all(curve.others == 0)


def test_points_of_the_curve_are_thresholds(upper):
    curve, _ = upper
    for i in range(5, len(curve.force), 17):
        forces = [t.force for t in hopf_thresholds(RodParameters(**{n: x[i] for n, x in curve.rods.items()}))]
        assert min(abs(f / curve.force[i] - 1) for f in forces) < 1e-10


def test_special_points_hold_to_1e_10_in_exact_arithmetic(upper):
    """With many digits on both sides of the points: what they are happens within 1e-10 of k1."""
    _, (bautin, closing) = upper
    assert (bautin.type, closing.type) == ("bautin", "closing")
    assert max(bautin.error, closing.error) < 1e-10

    def exact(k1):
        return exact_threshold(RodParameters(k1, 1e4, 1e-4), bautin.force, bautin.omega, 15)

    below, above = (exact(bautin.rod["k1"] * (1 + s)) for s in (-1e-10, 1e-10))
    assert below.alpha.real * above.alpha.real < 0
    assert abs(float(below.force) / bautin.force - 1) < 1e-8

    # two thresholds exist just beside the closing, and none just beyond it
    near = landau_batch(closing.rod["k1"] * (1 + 1e-10), 1e4, 1e-4)
    start = mp.mpf(float(near.force[0])), mp.mpf(float(near.omega[0]))
    with mp.workdps(20):
        force, _ = refine_threshold(RodParameters(closing.rod["k1"] * (1 + 1e-10), 1e4, 1e-4), *start)
        assert abs(float(force) / closing.force - 1) < 1e-4  # ∝ √(distance from the turning point)
        with pytest.raises(ComputationError):
            refine_threshold(RodParameters(closing.rod["k1"] * (1 - 1e-10), 1e4, 1e-4), *start)


def test_both_directions_find_the_same_points(upper):
    _, (bautin, closing) = upper
    t = hopf_thresholds(ROD)[0]
    _, again = threshold_curve(ROD, "k1", (t.force, t.omega), 140.0)
    for one, other in zip((closing, bautin), again, strict=True):
        assert one.type == other.type
        assert (one.rod["k1"], one.force, one.omega) == pytest.approx(
            (other.rod["k1"], other.force, other.omega), rel=1e-10
        )


def test_special_point_by_newtons_method(upper):
    for p in upper[1]:
        off = RodParameters(**p.rod | {"k1": p.rod["k1"] * 1.01})
        found = special_point(p.type, off, {"k1": None}, p.force * 1.01, p.omega * 0.98)
        assert (found.rod["k1"], found.force, found.omega) == pytest.approx(
            (p.rod["k1"], p.force, p.omega), rel=1e-10
        )
        assert found.error < 1e-9


def test_special_points_lie_on_curves_in_a_plane(upper):
    for point in upper[1]:
        curve = special_curve(point, ("k1", "k2"), 1e6)
        assert curve.end == "k2 is 1000000"
        assert curve.rods["k2"][-1] == pytest.approx(1e6)
        end = curve.rods["k1"][-1]
        # the same point, found on the line k2 = 1e6
        start = RodParameters(200, 1e6, 1e-4)
        t = hopf_thresholds(start)[1]
        found = {p.type: p for p in threshold_curve(start, "k1", (t.force, t.omega), 140.0)[1]}[point.type]
        assert (end, curve.force[-1]) == pytest.approx((found.rod["k1"], found.force), rel=1e-9)
        number = curve.alpha if point.type == "bautin" else curve.beta
        assert np.all(np.abs(number.real / np.abs(number)) < 1e-7)


def test_bautin_curve_passes_from_the_upper_to_the_lower_threshold():
    """As gamma3 grows, Re β changes its sign along the curve Re α = 0: there it touches the closing curve."""
    point = special_point("bautin", RodParameters(146.4, 1e4, 1e-3), {"k1": None}, 83.5, 905.0)
    up = special_curve(point, ("k1", "gamma3"), 1.0)
    assert (up.end, up.rods["gamma3"][-1]) == ("gamma3 is 1", pytest.approx(1.0))
    assert up.beta[0].real < 0 < up.beta[-1].real


def test_curve_ends_where_the_force_comes_to_k1():
    t = hopf_thresholds(RodParameters(300, 1e4, 5e-2))[1]
    curve, _ = threshold_curve(RodParameters(300, 1e4, 5e-2), "k1", (t.force, t.omega), 600.0)
    assert curve.end == "the straight rod comes to length 0"
    assert curve.force[-1] / curve.rods["k1"][-1] > 0.9999


@pytest.mark.parametrize("special", [None, "bautin", "closing"])
def test_jacobian_is_the_derivative(special):
    system = equations(ROD, {"k1": None, "gamma3": None}, special)
    t = hopf_thresholds(ROD)[0]
    X = np.log([200, 1e-4, t.force, t.omega])
    _, J = system.linearised(X)
    for j, step in enumerate(1e-6 * np.eye(4)):
        ahead, back = system.linearised(X + step)[0], system.linearised(X - step)[0]
        # the first two rows leave out the derivative of their scale, which counts only off the curve
        assert J[:, j] == pytest.approx((ahead - back) / 2e-6, rel=1e-4, abs=1e-6 * np.abs(J).max())


# ---- a toy with a double point: two pairs λ = F − p + i and λ = F − 2p + 1 + 2i, both on the axis at F = p
# = 1


def _toy_gradient(rods, names, force, lam):
    p = rods.values["k1"]
    values = [lam - (force - p + 1j), lam - (force - 2 * p + 1 + 2j)]
    by_p, by_force = (1, 2), (-1, -1)
    D = values[0] * values[1]
    slopes = [by_p[0] * values[1] + by_p[1] * values[0], by_force[0] * values[1] + by_force[1] * values[0]]
    return D, np.array([slopes[0], slopes[1], values[0] + values[1]])


def _toy_lines(rods, rod, force):
    p = rods.values["k1"][rod]
    unstable = 2 * (force > p).astype(int) + 2 * (force > 2 * p - 1).astype(int)
    return type("Lines", (), {"unstable": unstable})


class ToyRoute:
    """The two pairs of the toy, the second one roughly."""

    def __init__(self, rod):
        self.p = float(rod.k1)

    def leading(self, force, kept):
        return np.array([[force[0] - self.p + 1j, force[0] - 2 * self.p + 1 + 2.01j]]), None


@pytest.fixture
def toy(monkeypatch):
    monkeypatch.setattr(curves, "gradient", _toy_gradient)
    monkeypatch.setattr(curves, "lines", _toy_lines)
    monkeypatch.setattr(curves, "route_of", ToyRoute)

    def coefficients(parameters, force, omega):
        n = len(force)
        return Coefficients(np.full(n, -1 + 1j), np.full(n, 1 + 1j), np.zeros(n), np.zeros(n))

    monkeypatch.setattr(curves, "coefficients", coefficients)


def test_double_points_of_a_toy(toy, monkeypatch):
    monkeypatch.setattr(curves, "stretch", lambda rods, force: np.ones_like(force))
    curve, (point,) = threshold_curve(RodParameters(0.7, 1, 1, 1), "k1", (0.7, 1.0), 1.4)
    assert curve.force == pytest.approx(curve.rods["k1"], rel=1e-12)
    assert point.type == "double"
    assert (point.rod["k1"], point.force, point.omega, point.omega2) == pytest.approx((1, 1, 1, 2), rel=1e-12)


def test_special_points_that_cannot_be_refined_are_kept_with_their_error(upper, monkeypatch):
    def fails(*_):
        raise ConvergenceError("no")

    monkeypatch.setattr(curves, "locate", fails)
    t = hopf_thresholds(ROD)[1]
    _, rough = threshold_curve(ROD, "k1", (t.force, t.omega), 140.0)
    for a, b in zip(rough, upper[1], strict=True):
        assert a.type == b.type
        assert abs(a.force / b.force - 1) < a.error
        assert a.error > 1e-3 > b.error


# ---- the command


def run(*arguments):
    return cli.run(["curve", *arguments])


LINE = ["--k2", "1e4", "--gamma3", "1e-4", "--vary", "k1", "--from", "200", "--to", "140"]


def test_json(capsys, upper):
    assert run(*LINE, "--threshold", "2", "--json") == 0
    document = json.loads(capsys.readouterr().out)
    assert [p["type"] for p in document["points"]] == ["bautin", "closing"]
    for p, expected in zip(document["points"], upper[1], strict=True):
        assert (float(p["k1"]), float(p["force"])) == pytest.approx(
            (expected.rod["k1"], expected.force), rel=1e-10
        )
    curve = document["curve"]
    assert len(curve["k1"]) == len(curve["force"]) == len(curve["alpha_re"]) > 20
    assert document["rod"]["k1"] == "200"
    assert (curve["k1"][0], curve["k1"][-1]) == ("200.0", "200.0")  # as asked for, to the last bit
    assert {p["k2"] for p in document["points"]} == {document["rod"]["k2"]}


def test_two_parameters(capsys):
    arguments = [
        "--gamma3",
        "1e-4",
        "--vary",
        "k1,k2",
        "--from",
        "200,1e4",
        "--to",
        "140,2e4",
        "--threshold",
        "2",
    ]
    assert run(*arguments, "--json") == 0
    document = json.loads(capsys.readouterr().out)
    assert [c["type"] for c in document["curves"]] == ["bautin", "closing"]
    assert [(c["k2"][0], c["k2"][-1]) for c in document["curves"]] == 2 * [("10000.0", "20000.0")]
    assert run(*arguments) == 0
    printed = capsys.readouterr().out
    assert "150.6343180" in printed
    assert "The closing point from k1 = 147.92152 as k2 varies" in printed


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["--vary", "k9", "--from", "1", "--to", "2"], "what can vary is k1, k2, gamma3, gamma1"),
        (["--vary", "k1,k1", "--from", "1,1", "--to", "2,2"], "two different ones"),
        (["--vary", "k1", "--from", "1,2", "--to", "2"], "one value for each of k1"),
        (["--vary", "k1", "--from", "x", "--to", "2"], "--from (k1) is 'x'"),
        (["--vary", "k1", "--from", "-1", "--to", "2"], "greater than zero"),
        (["--vary", "k1", "--from", "2", "--to", "2"], "nothing to vary"),
        (["--vary", "k1", "--from", "2", "--to", "3"], "also needs --k2 and --gamma3"),
        ([*LINE, "--k1", "3"], "--k1 is given, but k1 varies"),
        ([*LINE, "--threshold", "3"], "has 2 thresholds up to force 200"),
        ([*LINE, "--threshold", "0"], "--threshold is 0"),
    ],
)
def test_bad_input(capsys, arguments, message):
    assert run(*arguments) == 2
    assert message in capsys.readouterr().err


def test_special_point_that_is_not_there():
    with pytest.raises(ComputationError):
        special_point("closing", RodParameters(1e4, 1e4, 1e-4), {"k1": None}, 37.7, 191.0)


def test_records_are_plain(upper):
    assert all(isinstance(p, SpecialPoint) and isinstance(p.force, float) for p in upper[1])
