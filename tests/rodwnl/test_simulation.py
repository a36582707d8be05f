"""The full rod in time: the equations, their integration, what is kept of a run, and its file."""

import json
import warnings
from functools import cache

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from rodwnl.angleform import AngleForm, angle_form
from rodwnl.cli import run
from rodwnl.collocation import chebyshev, discretise
from rodwnl.emittedlaw import emitted_law
from rodwnl.errors import ComputationError, InputError
from rodwnl.orbits import onset, orbit_at
from rodwnl.parameters import RodParameters
from rodwnl.simulation import perturbed, simulate, to_dataset
from rodwnl.spectrum import hopf_thresholds
from rodwnl.storage import load, require_writable, save

FIRST = RodParameters("1e4", "1e4", "1e-4")
RODS = [
    (FIRST, 37.66),
    (RodParameters("1e4", "1e2", "1e-2"), 27.43),
    (RodParameters(200, "1e4", "1e-4"), 155.6),
]
HOPELESS = RodParameters("1e4", "1e4", "1e-30")  # its rates differ by more than double precision holds
FIRST_OPTIONS = ["--k1", "1e4", "--k2", "1e4", "--gamma3", "1e-4"]


@cache
def bent(rod: RodParameters, force: float, degree: int) -> tuple[AngleForm, np.ndarray]:
    """A state far from straight that has forgotten its start: its velocities fit its ends as well."""
    form = angle_form(rod, force, degree)
    start = perturbed(form, 0.4)
    run = solve_ivp(
        lambda t, q: form.rhs(q), (0, 5e-3), start, "BDF", rtol=1e-6, atol=1e-8,
        jac=lambda t, q: form.jacobian(q),
    )  # fmt: skip
    return form, run.y[:, -1]


def velocities(form: AngleForm, q: np.ndarray, step: float = 1e-6) -> tuple[np.ndarray, ...]:
    """x_t, y_t, θ_t at all nodes, as the state moves along f."""
    f = form.rhs(q)
    scale = step / np.abs(f).max()
    after, before = form.fields(q + scale * f), form.fields(q - scale * f)
    return tuple((a - b) / (2 * scale) for a, b in zip(after[:3], before[:3], strict=True))


def fixed_frame(form: AngleForm, q: np.ndarray) -> tuple[np.ndarray, ...]:
    """x_t, y_t, θ_t at the inner nodes from the balance in the fixed frame, written for this test.

    Force on the section R(θ)(F1, F2); its derivative along the rod is balanced by the drag R(θ) Γ R(θ)ᵀ r_t.
    """
    x, y, theta, _ = form.fields(q)
    d = chebyshev(form.nodes.size - 1).first
    e1, e2 = np.array([np.cos(theta), np.sin(theta)]), np.array([-np.sin(theta), np.cos(theta)])
    tangent = np.array([d @ x, d @ y])
    F1, F2 = form.k1 * ((e1 * tangent).sum(axis=0) - 1), form.k2 * (e2 * tangent).sum(axis=0)
    F1[-1], F2[-1] = -form.force, 0.0
    force = e1 * F1 + e2 * F2
    pull = force @ d.T
    velocity = e1 * (e1 * pull).sum(axis=0) / form.gamma1 + e2 * (e2 * pull).sum(axis=0)
    moment = d @ theta
    moment[-1] = 0.0
    turning = (d @ moment + tangent[0] * force[1] - tangent[1] * force[0]) / form.gamma3
    return velocity[0, 1:-1], velocity[1, 1:-1], turning[1:-1]


@pytest.mark.parametrize(("rod", "force"), RODS)
def test_the_equations_agree_with_the_balance_in_the_fixed_frame(rod, force):
    def mismatch(degree: int) -> float:
        form, q = bent(rod, force, degree)
        ours, theirs = velocities(form, q), fixed_frame(form, q)
        pairs = zip(ours, theirs, strict=True)
        return max(float(np.abs(a[1:-1] - b).max() / np.abs(b).max()) for a, b in pairs)

    assert mismatch(32) < 1e-4
    assert mismatch(16) > 1e3 * mismatch(32)


@pytest.mark.parametrize(("rod", "force"), RODS)
def test_the_equations_agree_with_the_displacement_form(rod, force):
    form, q = bent(rod, force, 32)
    other = discretise(*rod.floats(), force, 32)
    at = np.searchsorted(form.nodes, other.nodes)
    theirs = other.split(other.rhs(other.state(*(field[at] for field in form.fields(q)[:3]))))
    for ours, their in zip(velocities(form, q), theirs, strict=True):
        np.testing.assert_allclose(ours[at], their, atol=1e-4 * np.abs(their).max())


@pytest.mark.parametrize(("rod", "force"), RODS)
def test_elastic_energy_changes_by_drag_and_by_the_follower_force_alone(rod, force):
    """dU/dt = −∫(γ1 v1² + v2² + γ3 Ω²) du − F v1(1)."""
    form, q = bent(rod, force, 28)
    grid = chebyshev(28)

    def energy(q: np.ndarray) -> float:
        x, y, theta, F1 = form.fields(q)
        F2 = form.k2 * (np.cos(theta) * (grid.first @ y) - np.sin(theta) * (grid.first @ x))
        return 0.5 * float(grid.weights @ (F1**2 / form.k1 + F2**2 / form.k2 + (grid.first @ theta) ** 2))

    f = form.rhs(q)
    step = 1e-6 / np.abs(f).max()
    rate = (energy(q + step * f) - energy(q - step * f)) / (2 * step)
    x_t, y_t, theta_t = velocities(form, q)
    theta = form.fields(q)[2]
    v1, v2 = np.cos(theta) * x_t + np.sin(theta) * y_t, np.cos(theta) * y_t - np.sin(theta) * x_t
    drag = grid.weights @ (form.gamma1 * v1**2 + v2**2 + form.gamma3 * theta_t**2)
    assert rate == pytest.approx(-drag - force * v1[-1], rel=2e-5)


@pytest.mark.parametrize(("rod", "force"), RODS)
def test_the_jacobian_is_the_derivative(rod, force):
    form, q = bent(rod, force, 12)
    direction = np.random.default_rng(1).standard_normal(form.size)
    numeric = (form.rhs(q + 1e-5 * direction) - form.rhs(q - 1e-5 * direction)) / 2e-5
    np.testing.assert_allclose(form.jacobian(q) @ direction, numeric, atol=1e-7 * np.abs(numeric).max())


@pytest.mark.parametrize("rod", [rod for rod, _ in RODS])
def test_the_straight_rod_rests_and_is_neutral_at_its_thresholds(rod):
    for threshold in hopf_thresholds(rod):
        form = angle_form(rod, threshold.force, 28)
        assert not form.rhs(np.zeros(form.size)).any()
        eigenvalues = np.linalg.eigvals(form.jacobian(np.zeros(form.size)))
        nearest = eigenvalues[np.abs(eigenvalues - 1j * threshold.omega).argmin()]
        assert nearest == pytest.approx(1j * threshold.omega, rel=1e-7)


def test_a_run_follows_the_displacement_form_under_another_integrator():
    """From a shape in the middle of the run (the start does not fit the tip conditions) to its end."""
    ours = simulate(FIRST, 40, "0.05", "0.1", 24, 1e-9)
    middle = ours.frame_time.size // 2
    other = discretise(*FIRST.floats(), 40.0, 24)
    at = np.searchsorted(ours.nodes, other.nodes)
    start = other.state(*(field[middle, at] for field in (ours.x, ours.y, ours.theta)))
    theirs = solve_ivp(
        lambda t, q: other.rhs(q), (ours.frame_time[middle], ours.time[-1]), start, "BDF",
        rtol=1e-8, atol=1e-10,
        jac=lambda t, q: other.jacobian(q),
    )  # fmt: skip
    tip = other.tip(theirs.y[:, -1])
    np.testing.assert_allclose([ours.tip_x[-1], ours.tip_y[-1], ours.tip_theta[-1]], tip, atol=3e-7)


@pytest.fixture(scope="module")
def settled():
    return simulate(FIRST, 42, "1.2", "0.1")


def test_a_settled_run_lies_on_the_periodic_orbit(settled):
    threshold = hopf_thresholds(FIRST)[0]
    from rodwnl.branches import branch

    law = emitted_law(FIRST)
    guess = branch(FIRST, threshold.force, threshold.omega, until=42.0).last
    orbit = orbit_at(guess, 42.0)
    assert onset(law, threshold.force, threshold.omega).point.X[-2] == pytest.approx(threshold.force)
    reading = settled.reading
    assert reading.state == "settled"
    assert reading.A_tip == pytest.approx(orbit.A_tip, rel=3e-6)
    assert reading.omega == pytest.approx(orbit.omega, rel=3e-7)
    assert settled.resolved
    assert settled.tip_residual < 1e-7


def test_a_run_keeps_shapes_that_end_where_the_tip_is(settled):
    assert settled.time[0] == 0
    assert settled.time[-1] == pytest.approx(1.2)
    for field, tip in [("x", "tip_x"), ("y", "tip_y"), ("theta", "tip_theta")]:
        last = getattr(settled, tip)[-len(settled.frame_time) :]
        np.testing.assert_array_equal(getattr(settled, field)[:, -1], last)
        assert not getattr(settled, field)[:, 0].any()
    np.testing.assert_allclose(settled.axial_force[:, -1], -42.0, rtol=1e-9)


def test_a_grid_that_is_too_coarse_is_noticed_and_auto_refines_it():
    coarse = simulate(FIRST, 60, "0.3", "0.1", nodes=8)
    assert not coarse.resolved
    fine = simulate(FIRST, 60, "0.3", "0.1")
    assert fine.resolved
    assert fine.nodes.size > 17


def test_an_interrupt_keeps_what_was_computed():
    def interrupt(done: float) -> None:
        if done > 0.5:
            raise KeyboardInterrupt

    stopped = simulate(FIRST, 38, "0.5", progress=interrupt)
    assert not stopped.complete
    assert 0.5 < stopped.time[-1] / 0.5 < 0.8
    whole = simulate(FIRST, 38, "0.5")
    np.testing.assert_allclose(stopped.tip_y, whole.tip_y[: stopped.tip_y.size], atol=1e-9)


@pytest.mark.parametrize(
    ("given", "message"),
    [
        ({"force": 0}, "force is 0, but a simulation needs"),
        ({"force": "1e4"}, "only for 0 <= force < k1 = 10000"),
        ({"force": -3}, "force is -3"),
        ({"time": -1}, "time is -1, but it must be greater than zero"),
        ({"time": "1e9"}, r"at most 2000000 are kept; simulate a shorter time"),
        ({"nodes": 7}, "nodes is 7, but it must be auto or a whole number from 8 to 128"),
        ({"rtol": 1.0}, "rtol is 1.0, but it must lie between"),
        ({"perturbation": "1e3"}, "its size must not exceed 3"),
        ({"perturbation": "nan"}, "perturbation is 'nan': not a finite number"),
    ],
)
def test_bad_input_is_refused_with_its_reason(given, message):
    with pytest.raises(InputError, match=message):
        simulate(**{"rod": FIRST, "force": 38, **given})


def test_a_run_that_the_integrator_cannot_do_fails_with_its_reason():
    with pytest.raises(ComputationError, match=r"gave up at t = .* A smaller perturbation"):
        simulate(HOPELESS, 38, "0.1", nodes=16)


def test_a_file_holds_the_run_and_how_to_repeat_it(settled, tmp_path):
    path = tmp_path / "run.nc"
    save(to_dataset(settled), path)
    dataset = load(path)
    np.testing.assert_array_equal(dataset["tip_y"], settled.tip_y)
    np.testing.assert_array_equal(dataset["F1"], settled.axial_force)
    assert dataset["y"].dims == ("frame", "node")
    assert all({"units", "long_name"} <= set(v.attrs) for v in dataset.variables.values())
    assert (dataset.attrs["k1"], dataset.attrs["force"], dataset.attrs["state"]) == ("10000", 42.0, "settled")
    assert dataset.attrs["A_tip"] == settled.reading.A_tip
    assert [p.name for p in tmp_path.iterdir()] == ["run.nc"]


def test_a_write_that_fails_leaves_the_old_file_and_nothing_else(settled, tmp_path, monkeypatch):
    import xarray

    path = tmp_path / "run.nc"
    path.write_bytes(b"old")

    def half(self, target, **options):
        with open(target, "wb") as file:
            file.write(b"half")
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(xarray.Dataset, "to_netcdf", half)
    with pytest.raises(OSError, match="No space left"):
        save(to_dataset(settled), path)
    assert path.read_bytes() == b"old"
    assert [p.name for p in tmp_path.iterdir()] == ["run.nc"]


def test_a_place_that_cannot_be_written_is_refused(tmp_path):
    with pytest.raises(InputError, match=r"the folder .* does not exist"):
        require_writable(tmp_path / "none" / "run.nc")
    with pytest.raises(InputError, match="it is a folder"):
        require_writable(tmp_path)
    with pytest.raises(InputError, match=r"needs about \d+ MB and \d+ MB are free"):
        require_writable(tmp_path / "run.nc", 10**18)
    with pytest.raises(InputError, match="there is no file"):
        load(tmp_path / "none.nc")
    (tmp_path / "text.nc").write_text("not a file of this kind")
    with pytest.raises(InputError, match="not a netCDF file that can be read"):
        load(tmp_path / "text.nc")


def test_the_command_prints_what_the_run_gives(capsys, tmp_path):
    path = tmp_path / "run.nc"
    options = [*FIRST_OPTIONS, "--force", "42", "--time", "0.6", "--perturbation", "0.1"]
    assert run(["simulate", *options, "--out", str(path), "--reduced", "--json"]) == 0
    document = json.loads(capsys.readouterr().out)
    run_again = simulate(FIRST, 42, "0.6", "0.1")
    assert float(document["simulation"]["A_tip"]) == pytest.approx(run_again.reading.A_tip, rel=1e-9)
    assert float(document["reduced_model"]["A_tip"]) > 1.02 * run_again.reading.A_tip
    assert load(path).attrs["A_tip"] == pytest.approx(run_again.reading.A_tip, rel=1e-9)
    assert run(["simulate", *options]) == 0
    printed = capsys.readouterr().out
    assert "The oscillation has settled." in printed or "The run has not finished" in printed
    assert "full rod" in printed


def test_the_command_refuses_a_bad_file_before_the_run(capsys, monkeypatch, tmp_path):
    def never(*arguments, **options):
        raise AssertionError("the run was started")

    monkeypatch.setattr("rodwnl.simulation.simulate", never)
    out = str(tmp_path / "none" / "run.nc")
    assert run(["simulate", *FIRST_OPTIONS, "--force", "38", "--out", out]) == 2
    error = capsys.readouterr().err
    assert error.count("\n") == 1
    assert "does not exist" in error


def test_a_failing_run_prints_one_line(capsys):
    options = ["--k1", "1e4", "--k2", "1e4", "--gamma3", "1e-30", "--force", "38", "--time", "0.1"]
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        assert run(["simulate", *options]) == 2
    captured = capsys.readouterr()
    assert captured.out == ""
    assert captured.err.count("\n") == 1
