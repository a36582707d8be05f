"""Batch, sweep, curve and atlas for rods of other models, against the route of a single rod."""

import json
from pathlib import Path

import numpy as np
import pytest

from rodwnl import (
    RodParameters,
    atlas,
    batch,
    cli,
    curves,
    hopf_thresholds,
    landau,
    landau_batch,
)
from rodwnl import sweep as sweeps
from rodwnl.batch import Status
from rodwnl.batch_characteristic import gradient, jet, problem_with_slopes
from rodwnl.batch_coefficients import coefficients
from rodwnl.batch_rods import Rods
from rodwnl.batch_spectrum import lines
from rodwnl.collocated import leading_eigenvalues, unstable_count
from rodwnl.curves import special_point, threshold_curve
from rodwnl.errors import ComputationError, InputError
from rodwnl.grids import grid, read_grid
from rodwnl.jets import Jet, Powers
from rodwnl.jets import coefficients as by_power
from rodwnl.models import emitted

from .agreement import NUMBERS, assert_same_numbers

EXAMPLES = Path(__file__).parents[2] / "examples"


@pytest.fixture(scope="module")
def tip_drag(tmp_path_factory):
    """A rod from a file: drag and a spring at its tip, so that its tip conditions mix even and odd shapes."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("RODWNL_CACHE", str(tmp_path_factory.mktemp("cache")))
        yield emitted(str(EXAMPLES / "tip_drag.toml"))


def sample(count, seed, **own):
    """Rods of which half lie in and around the reentrant windows; own: ranges of a model's own parameters."""
    rng = np.random.default_rng(seed)
    half = count // 2
    k1 = np.concatenate([10 ** rng.uniform(2, 5, count - half), rng.uniform(140, 230, half)])
    k2 = np.concatenate([10 ** rng.uniform(1.5, 5, count - half), 10 ** rng.uniform(3.5, 5, half)])
    values = {
        "k1": k1,
        "k2": k2,
        "gamma3": 10 ** rng.uniform(-5, -1, count),
        "gamma1": rng.uniform(0.2, 1, count),
    }
    return values | {name: rng.uniform(*limits, count) for name, limits in own.items()}


def compare(model, values, least_windows):
    """landau_batch and landau on every rod."""
    found, compared = landau_batch(**values, model=model), 0
    for i in range(len(values["k1"])):
        rod = RodParameters(**{name: float(x[i]) for name, x in values.items()}, model=model)
        try:
            expected = landau(rod)
        except ComputationError:
            continue  # the scan of the single rod sometimes gives up where eigenvalues are real and far apart
        compared += 1
        assert found.count[i] == len(expected), rod
        assert found.status[i] == (Status.FOUND if len(expected) else Status.NONE), rod
        assert_same_numbers(found, i, expected, rod)
    assert compared >= 6
    assert np.sum(found.count >= 2) >= least_windows


@pytest.mark.parametrize(
    ("model", "own"),
    [
        ("metric_drag", {}),
        ("quartic", {"stretch4": (0, 300), "bend4": (0, 1)}),
        ("partial_follower", {"chi": (0.7, 1.1)}),
    ],
)
def test_agrees_with_the_single_rod_route(model, own):
    compare(model, sample(8, 21, **own), least_windows=2)


def test_a_spring_alone_at_the_tip(sprung):
    """Of the two terms that mix even and odd shapes it has one."""
    kappa = [-0.5, 5.0, 50.0, -1.1, -5.0]
    rods = [sprung(("200", "1e4", "1e-4"), k) for k in kappa]
    found = landau_batch(200.0, 1e4, 1e-4, model=rods[0].model, kappa=kappa)
    assert found.status.tolist() == [
        Status.FOUND, Status.BUCKLES, Status.BUCKLES, Status.UNSTABLE, Status.UNSTABLE,
    ]  # fmt: skip
    for i, rod in enumerate(rods):
        search = hopf_thresholds(rod)
        assert (found.status[i] == Status.UNSTABLE) == (search.unstable_unloaded > 0)
        forces = found.force[i, : found.count[i]]
        assert forces == pytest.approx([t.force for t in search], rel=1e-9)
        if search.steady:
            assert found.buckling_force[i] == pytest.approx(search.steady[0].force, rel=1e-9)


def test_a_rod_unstable_without_a_force_is_said_to_be_so_by_either_route(sprung, monkeypatch):
    model = sprung(("200", "1e4", "1e-4"), -1.1).model
    settled = landau_batch(200.0, 1e4, 1e-4, model=model, kappa=-1.1)
    monkeypatch.setattr(batch, "ACCURACY", 1e-17)
    alone = landau_batch(200.0, 1e4, 1e-4, model=model, kappa=-1.1)
    assert settled.status == alone.status == Status.UNSTABLE
    assert settled.count == alone.count == 2
    assert alone.buckling_force == pytest.approx(float(settled.buckling_force), rel=1e-9)


def test_where_float64_has_too_few_digits_any_uniform_rod_is_made_exact(tip_drag):
    rod = (117.86683056335714, 679973.4253911484, 0.30266394862914264)
    found = landau_batch(*rod, model=tip_drag)
    assert found.status == Status.ESCALATED
    expected = landau(RodParameters(*rod, model=tip_drag))  # which takes the same step to more digits
    assert found.count == len(expected) == 2
    for j, c in enumerate(expected):
        assert found.alpha[j] == pytest.approx(c.alpha, rel=1e-9)
        assert found.beta[j] == pytest.approx(c.beta, rel=1e-9)


def test_lines_are_long_enough_where_the_straight_rod_ends():
    """At a stretch of a thousandth D comes to its dominant term slowly; a line too short has no count."""
    k1 = [48.21338033119926, 26.067569228624706, 20.977181037153162]
    k2 = [70.86361470456613, 58.53642650858118, 40.08762931181712]
    gamma3 = [5.024184855872888e-06, 2.2431127555049036e-06, 1.0209492626038288e-05]
    found = landau_batch(k1, k2, gamma3, model="partial_follower")
    assert found.status.tolist() == [Status.FOUND, Status.NONE, Status.NONE]
    for i, values in enumerate(zip(k1, k2, gamma3, strict=True)):
        rod = RodParameters(*values, model="partial_follower")
        assert_same_numbers(found, i, landau(rod), rod)
        assert found.count[i] == len(hopf_thresholds(rod))


def test_a_rod_from_a_file_agrees(tip_drag):
    own = {"axial": (0, 1), "transverse": (0, 0.3), "spring": (0, 2), "damper": (0, 0.01)}
    compare(tip_drag, sample(8, 22, **own), least_windows=2)


def test_own_parameters_broadcast_and_have_defaults():
    found = landau_batch(200, 1e4, 1e-4, model="partial_follower", chi=np.array([[1.0], [0.9]]))
    assert found.force.shape == (2, 1, 4)
    plain = landau_batch(200, 1e4, 1e-4)
    np.testing.assert_allclose(found.force[0, 0], plain.force, rtol=1e-11)
    np.testing.assert_allclose(found.alpha[0, 0], plain.alpha, rtol=1e-9)
    assert np.array_equal(
        found.alpha[1, 0], landau_batch(200, 1e4, 1e-4, model="partial_follower").alpha, True
    )
    with pytest.raises(InputError, match="has no parameter 'psi'; its own are chi"):
        landau_batch(200, 1e4, 1e-4, model="partial_follower", psi=1)


def test_bad_rods_among_good_ones():
    k1 = [200, np.nan, 200, 200, 200]
    stretch4 = [100, 100, np.inf, -1e4, 100]
    found = landau_batch(k1, [1e4, 1e4, 1e4, 1e4, -1], 1e-4, model="quartic", stretch4=stretch4)
    good = landau(RodParameters(200, 1e4, 1e-4, model="quartic"))
    assert found.status[[0, 1, 2, 4]].tolist() == [Status.FOUND, *[Status.FAILED] * 3]
    assert found.force[0, : len(good)] == pytest.approx([c.force for c in good], rel=1e-10)
    assert found.reasons[2] == "stretch4 must be finite"
    assert "must be finite and positive" in found.reasons[1]
    # a rod that softens carries little: the search ends where its straight state does
    soft = hopf_thresholds(RodParameters(200, 1e4, 1e-4, model="quartic", stretch4=-10000))
    assert (found.status[3], len(soft)) == (Status.NONE, 0)


def test_rods_without_a_straight_state_say_so(tmp_path, monkeypatch):
    monkeypatch.setenv("RODWNL_CACHE", str(tmp_path))
    file = tmp_path / "stiff.toml"
    text = (EXAMPLES / "follower.toml").read_text().replace('name = "follower"', 'name = "stiff"')
    file.write_text(
        text.replace("Pi^2/2", "bend*Pi^2/2").replace(
            "[drag]", '[parameters]\nbend = { default = "1", meaning = "bending stiffness" }\n[drag]', 1
        )
    )
    found = landau_batch(200, 1e4, 1e-4, model=emitted(str(file)), bend=[1.0, -1.0])
    assert found.status.tolist() == [Status.FOUND, Status.FAILED]
    assert "the bending stiffness is -1" in found.reasons[1]
    assert found.force[0] == pytest.approx(landau_batch(200, 1e4, 1e-4).force, rel=1e-11, nan_ok=True)


# ---- buckling


def test_buckling_has_a_closed_form():
    """Steady, k2 H = F(Θ − χΘ(1)) and Θ'' + μH = 0: cos p = −χ/(1 − χ) with p² = F(ν + F/k2)."""
    chi = np.linspace(-0.5, 0.49, 12)
    k1, k2 = np.array([[1e4], [200], [1e3]]), np.array([[1e4], [100], [30]])
    found = landau_batch(k1, k2, 1e-3, max_force=60, model="partial_follower", chi=chi)
    assert np.all(found.status == Status.BUCKLES)
    a, b = 1 / k2 - 1 / k1, np.arccos(-chi / (1 - chi)) ** 2  # a F² + F = b
    np.testing.assert_allclose(found.buckling_force, 2 * b / (1 + np.sqrt(1 + 4 * a * b)), rtol=1e-11)
    flutter = landau_batch(k1, k2, 1e-3, max_force=60, model="partial_follower", chi=0.6)
    assert np.all(flutter.status == Status.FOUND)
    assert np.all(np.isnan(flutter.buckling_force))


@pytest.mark.parametrize("below", [1e-4, 1e-5, 1e-7, 1e-8])
def test_a_window_of_buckling_between_two_samples_is_seen(below):
    """At χ = 1/2 a real eigenvalue touches 0 at F = π²; before, it crosses twice, √(1/2 − χ) apart."""
    rod = {"k1": 1e4, "k2": 1e4, "gamma3": 1e-4, "chi": 0.5 - below}
    found = landau_batch(**rod, model="partial_follower", max_force=100)
    single = hopf_thresholds(RodParameters(**rod, model="partial_follower"), 100)
    assert found.status == Status.BUCKLES
    assert found.buckling_force == pytest.approx(single.steady[0].force, rel=1e-9)


def test_a_rod_may_buckle_straighten_and_flutter():
    values = {"k1": 187, "k2": 240, "gamma3": 1e-4, "gamma1": 0.9}
    rod = RodParameters(**values, model="partial_follower", chi="0.455")
    found, single = landau_batch(**values, model="partial_follower", chi=0.455), landau(rod)
    assert found.status == Status.BUCKLES
    assert found.buckling_force == pytest.approx(single.search.steady[0].force, rel=1e-10)
    assert len(single.search.steady) == 2
    assert found.count == len(single) == 1
    assert single.search.steady[1].force < found.force[0] == pytest.approx(single[0].force, rel=1e-10)
    assert found.alpha[0] == pytest.approx(single[0].alpha, rel=1e-9)


# ---- the stages


def test_eigenvalues_are_zeros_and_counted(tip_drag):
    own = {"axial": 0.5, "transverse": 1.0, "spring": 0.05, "damper": 0.01}
    for model, given in ((tip_drag, own), ("partial_follower", {"chi": 0.3}), ("metric_drag", {})):
        values = {"k1": 900.0, "k2": 700.0, "gamma3": 1e-2, "gamma1": 0.5} | given
        rod = RodParameters(**values, model=model)
        rods = Rods(model, {name: np.array([x]) for name, x in values.items()})
        for force in (1.0, 12.0, 30.0, 90.0):
            for lam in leading_eigenvalues(rod, np.array([force]))[0][0][:4]:
                D, _, D_lam = jet(problem_with_slopes(rods, np.array([force])), np.array([lam]))
                assert abs(D / D_lam) < 1e-11 * abs(lam)
            counted = lines(rods, np.array([0]), np.array([force]))
            assert counted.unstable[0] == unstable_count(rod, force)


def test_derivatives_through_an_implicit_stretch():
    values = {"k1": 150.0, "k2": 1e3, "gamma3": 1e-2, "gamma1": 0.5, "stretch4": 90.0, "bend4": 0.1}
    force, lam = np.array([40.0]), np.array([30 + 200j])
    names = ("k1", "stretch4", "bend4")

    def at(**changed):
        rods = Rods("quartic", {n: np.array([x]) for n, x in (values | changed).items()})
        return gradient(rods, names, changed.get("force", force), lam)

    D, slopes = at()
    for i, name in enumerate(names):
        h = 1e-5 * values[name]
        seen = (at(**{name: values[name] + h})[0] - at(**{name: values[name] - h})[0]) / (2 * h)
        np.testing.assert_allclose(slopes[i], seen, rtol=1e-6, atol=1e-12 * abs(D[0]))
    rods = Rods("quartic", {n: np.array([x]) for n, x in values.items()})
    ahead, back = (jet(problem_with_slopes(rods, force + s), lam)[0] for s in (1e-3, -1e-3))
    np.testing.assert_allclose(slopes[3], (ahead - back) / 2e-3, rtol=1e-6)


def test_numbers_that_formulas_are_called_with():
    r = Powers({1: 1})
    value = (3 * r**3 - r / 2 + 1) / (2 * r)
    assert by_power(value) == {2: 1.5, 0: -0.25, -1: 0.5}
    x = Jet(np.array([2.0]), np.array([[1.0]]))
    both = by_power((x * r + 1) / (r * x**2))  # r⁰/x + r⁻¹/x²
    assert both[0].value == pytest.approx(0.5)
    assert both[0].slopes == pytest.approx(-0.25)
    assert both[-1].slopes == pytest.approx(-2 / 8)


def test_residuals_betray_what_is_not_a_threshold(tip_drag):
    for model in (tip_drag, "partial_follower", "quartic"):
        one = landau(RodParameters(1e4, 1e4, 1e-4, model=model))
        values = {n: np.array([x]) for n, x in curves.parameter_values(one.rod).items()}
        force, omega = np.array([one[0].force]), np.array([one[0].omega])
        assert coefficients(Rods(model, values), force, omega).residual < 1e-11
        assert coefficients(Rods(model, values), force * (1 + 1e-6), omega).residual > 1e-9


# ---- a load spread along the rod


def test_a_distributed_load_is_computed_rod_by_rod():
    found = landau_batch([1e4, -1], 1e3, 1e-3, model="distributed")
    (single,) = landau(RodParameters(1e4, 1e3, 1e-3, model="distributed"))
    assert found.status.tolist() == [Status.ESCALATED, Status.FAILED]
    for name in NUMBERS:
        assert getattr(found, name)[0, 0] == pytest.approx(getattr(single, name), rel=1e-12)
    assert 0 < found.error[0, 0] < 1e-8


@pytest.mark.parametrize("command", ["curve", "atlas"])
def test_what_needs_constant_coefficients_refuses_it(command, tmp_path, capsys):
    options = {
        "curve": ["--k2", "1e4", "--gamma3", "1e-4", "--vary", "k1", "--from", "200", "--to", "100"],
        "atlas": ["--out", str(tmp_path / "atlas")],
    }
    assert cli.run([command, "--model", "distributed", *options[command]]) == 2
    said = capsys.readouterr().err
    assert "needs coefficients that are constant along the rod" in said
    assert said.count("\n") == 1
    assert not list(tmp_path.iterdir())


# ---- sweeps


@pytest.fixture
def chi_grid(tmp_path):
    pytest.importorskip("h5netcdf")
    path = tmp_path / "chi.toml"
    path.write_text(
        'model = "partial-follower"\nk2 = 1e4\ngamma3 = 1e-4\nk1 = 200\n[chi]\nlinear = [0, 1]\npoints = 7\n'
    )
    return path


def test_an_own_parameter_is_an_axis(chi_grid, monkeypatch):
    xr = pytest.importorskip("xarray")
    assert cli.run(["sweep", str(chi_grid), "--workers", "1"]) == 0
    with xr.open_dataset(chi_grid.with_suffix(".nc"), engine="h5netcdf") as data:
        assert dict(data.sizes) == {"chi": 7, "threshold": 4}
        assert data.attrs["rod"] == "partial_follower"
        assert (
            data.attrs["emitted_code"]
            != sweeps.provenance(grid({"k1": 1, "k2": 1, "gamma3": 1}))["emitted_code"]
        )
        expected = landau_batch(200, 1e4, 1e-4, model="partial_follower", chi=data.chi.values)
        assert np.array_equal(data.force.values, expected.force, equal_nan=True)
        assert np.array_equal(data.buckling_force.values, expected.buckling_force, equal_nan=True)
        assert data.status.attrs["flag_meanings"].split()[4] == "buckles"
        assert set(data.status.values.tolist()) == {Status.FOUND, Status.BUCKLES}


def test_resumed_is_bit_identical_and_another_model_is_refused(chi_grid, tmp_path, monkeypatch, capsys):
    from rodwnl import engines

    monkeypatch.setattr(sweeps, "BLOCK", 2)
    here = [lambda tasks, _: ((t[0], engines.compute(*t[1:])) for t in tasks)]
    monkeypatch.setattr(sweeps, "on_this_machine", lambda tasks, workers: here[-1](tasks, workers))
    whole, part = tmp_path / "whole.nc", tmp_path / "part.nc"
    sweeps.sweep(read_grid(chi_grid), whole)

    def killed(tasks, workers):
        yield next(iter(here[0](tasks, workers)))
        raise KeyboardInterrupt

    here.append(killed)
    with pytest.raises(KeyboardInterrupt):
        sweeps.sweep(read_grid(chi_grid), part)
    here.pop()
    other = chi_grid.with_name("other.toml")
    other.write_text(
        chi_grid.read_text()
        .replace("partial-follower", "follower")
        .replace("[chi]", "[gamma1]")
        .replace("0, 1", "1, 2")
    )
    assert cli.run(["sweep", str(other), "--out", str(part), "--resume"]) == 2
    assert "its rod differs, there partial_follower, here follower" in capsys.readouterr().err
    sweeps.sweep(read_grid(chi_grid), part, resume=True)
    assert part.read_bytes() == whole.read_bytes()


def test_the_model_of_a_grid(tmp_path, tip_drag, monkeypatch):
    (tmp_path / "sub").mkdir()
    (tmp_path / "sub" / "mine.toml").write_text((EXAMPLES / "tip_drag.toml").read_text())
    monkeypatch.setenv("RODWNL_CACHE", str(Path(tip_drag).parents[1]))
    path = tmp_path / "grid.toml"
    path.write_text('model = "sub/mine.toml"\nk1 = 1e3\nk2 = 1e3\ngamma3 = 1e-3\nspring = 0\n')
    g = read_grid(path)  # relative to the grid, not to where the command runs
    assert g.model == tip_drag
    assert (g.values["spring"], g.values["axial"]) == (0, 0.05)
    path.write_text("k1 = 1e3\nk2 = 1e3\ngamma3 = 1e-3\n")
    g = read_grid(path, "partial-follower", {"chi": "-1/2"})
    assert (g.model, float(g.values["chi"])) == ("partial_follower", -0.5)


@pytest.mark.parametrize(
    ("text", "options", "message"),
    [
        ('model = "nothing"', [], "there is no rod 'nothing'; there are distributed, follower"),
        ('model = "no.toml"', [], "no.toml: No such file"),
        ("model = 3", [], "model must be a name or the path of a rod.toml"),
        ("chi = 1", [], "unknown key 'chi'"),
        ('model = "quartic"', ["--model", "quartic"], "it names a model, 'quartic': leave out --model"),
        ('model = "quartic"\nbend4 = 1', ["--parameter", "bend4=2"], "leave out --parameter bend4"),
        ("", ["--model", "quartic", "--parameter", "bend5=2"], "unknown key 'bend5': did you mean bend4"),
        ('model = "quartic"\n[bend4]\nlog = [0, 1]\npoints = 2', [], "bend4 is 0, but it must be greater"),
        ('model = "quartic"\nbend4 = "x"', [], "bend4 is 'x'"),
    ],
)  # fmt: skip
def test_bad_models_of_grids(tmp_path, capsys, text, options, message):
    path = tmp_path / "grid.toml"
    path.write_text(f"k1 = 1e3\nk2 = 1e3\ngamma3 = 1e-3\n{text}\n")
    assert cli.run(["sweep", str(path), *options]) == 2
    said = capsys.readouterr().err
    assert message in said
    assert said.count("\n") == 1


# ---- curves


def test_curve_in_an_own_parameter():
    """From chi = 1 down: each point is a threshold, the last one that of the batch and of the single rod."""
    rod = RodParameters(200, 1e4, 1e-4, model="partial_follower", chi=1)
    t = hopf_thresholds(rod)[0]
    curve, special = threshold_curve(rod, "chi", (t.force, t.omega), 0.6)
    assert curve.end == "chi is 0.6"
    assert not special
    assert np.all(np.diff(curve.rods["chi"]) < 0)
    found = landau_batch(200, 1e4, 1e-4, model="partial_follower", chi=curve.rods["chi"])
    np.testing.assert_allclose(curve.force, found.force[:, 0], rtol=1e-10)
    np.testing.assert_allclose(curve.alpha, found.alpha[:, 0], rtol=1e-9)
    (end, *_) = landau(RodParameters(200, 1e4, 1e-4, model="partial_follower", chi="0.6"))
    assert (curve.force[-1], curve.omega[-1]) == pytest.approx((end.force, end.omega), rel=1e-10)
    assert curve.beta[-1] == pytest.approx(end.beta, rel=1e-9)


def test_a_curve_ends_where_the_frequency_comes_to_0(capsys):
    line = ["--k1", "200", "--k2", "1e4", "--gamma3", "1e-4", "--model", "partial-follower", "--vary", "chi"]
    assert cli.run(["curve", *line, "--from", "0.6", "--to", "0", "--json"]) == 0
    document = json.loads(capsys.readouterr().out)
    curve = document["curve"]
    assert curve["end"] == "the frequency comes to 0"
    assert document["rod"]["model"] == "partial_follower"
    # two real eigenvalues are 0 there; the closed form of the force at which one is, in its other branch
    chi, force = float(curve["chi"][-1]), float(curve["force"][-1])
    p = 2 * np.pi - np.arccos(-chi / (1 - chi))
    assert force * (1 - force / 200 + force / 1e4) == pytest.approx(p**2, rel=1e-6)


def test_special_points_checked_with_single_rods():
    """Bautin: Re α changes its sign. Closing: two thresholds on one side of it, none on the other."""
    rod = RodParameters(200, 1e4, 1e-4, model="quartic")
    t = hopf_thresholds(rod)[1]
    _, special = threshold_curve(rod, "k1", (t.force, t.omega), 100.0)
    points = {p.type: p for p in special}
    assert set(points) >= {"closing"}

    def beside(p, distance):
        given = {n: float(x) for n, x in p.rod.items()} | {"k1": p.rod["k1"] * (1 + distance)}
        return landau(RodParameters(**given, model="quartic"), 1000)

    closing = points["closing"]
    assert len(beside(closing, 1e-5)) == len(beside(closing, -1e-5)) + 2
    near = min(beside(closing, 1e-6), key=lambda c: abs(c.force - closing.force))
    assert near.force == pytest.approx(closing.force, rel=1e-2)
    stiff = RodParameters(400, 1e5, 1e-4, model="quartic")
    t = hopf_thresholds(stiff, 1000)[1]
    _, special = threshold_curve(stiff, "k1", (t.force, t.omega), 200.0)
    (bautin,) = (p for p in special if p.type == "bautin")
    signs = []
    for distance in (-1e-6, 1e-6):
        c = min(beside(bautin, distance), key=lambda c: abs(c.force - bautin.force))
        assert c.force == pytest.approx(bautin.force, rel=1e-4)
        signs.append(np.sign(c.alpha.real))
    assert sorted(signs) == [-1, 1]
    again = special_point(
        "bautin", RodParameters(**bautin.rod, model="quartic"), {"k1": None}, bautin.force, bautin.omega
    )
    assert again.rod["k1"] == pytest.approx(bautin.rod["k1"], rel=1e-9)


def test_a_parameter_that_moves_nothing_has_no_closing():
    rod = RodParameters(200, 1e4, 1e-4, model="quartic")
    with pytest.raises(ComputationError):
        special_point("closing", rod, {"bend4": 1.0}, 50.0, 330.0)


# ---- the atlas


def test_an_atlas_of_another_rod(tmp_path, monkeypatch, capsys):
    xr = pytest.importorskip("xarray")
    pytest.importorskip("h5netcdf")
    pytest.importorskip("matplotlib")
    monkeypatch.setattr(atlas, "MAPS", atlas.MAPS[:1])
    out = tmp_path / "atlas"
    options = ["--model", "partial-follower", "--parameter", "chi=0.45", "--points", "6", "--workers", "1"]
    assert cli.run(["atlas", "--out", str(out), *options]) == 0
    name = atlas.MAPS[0].name
    summary = json.loads((out / "summary.json").read_text())
    assert (summary["model"], summary["parameters"]) == ("partial_follower", {"chi": 0.45})
    counts = summary["maps"][name]
    assert sum(counts["regions"].values()) + counts["buckle"] + counts["buckle and flutter"] == 36
    assert counts["buckle and flutter"] > 15
    with xr.open_dataset(out / f"{name}.nc", engine="h5netcdf") as data:
        here = data.isel(k1=5, k2=4)
        values = {"k1": float(here.k1), "k2": float(here.k2), "gamma3": "1e-4"}
        single = hopf_thresholds(RodParameters(**values, model="partial_follower", chi="0.45"))
        assert float(here.force[0]) == pytest.approx(single[0].force, rel=1e-9)
    assert (out / f"{name}.csv").read_text().startswith("type,curve,k1,k2,gamma3,gamma1,chi,force")
    assert cli.run(["atlas", "--out", str(tmp_path / "b"), "--model", "quartic", "--parameter", "chi=1"]) == 2
    assert "unknown key 'chi'" in capsys.readouterr().err
    assert not (tmp_path / "b").exists()
