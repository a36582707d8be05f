"""The reduced model: the amplitude equation's solution, and the shapes it stands for."""

import json
from pathlib import Path

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from rodwnl import cli
from rodwnl.angleform import angle_form
from rodwnl.coefficients import landau
from rodwnl.coexistence import periodic_orbits
from rodwnl.collocation import chebyshev
from rodwnl.emittedlaw import emitted_law
from rodwnl.errors import ComputationError, InputError
from rodwnl.models import emitted
from rodwnl.parameters import RodParameters
from rodwnl.predictions import predict_at
from rodwnl.reduced import reduced_model, stuart_landau
from rodwnl.simulation import simulate

FIRST = RodParameters("1e4", "1e4", "1e-4")
LOADED = str(Path(__file__).parents[2] / "examples" / "loaded.toml")
REENTRANT = RodParameters(200, "1e4", "1e-4")


@pytest.mark.parametrize(
    ("alpha", "sigma", "A0"),
    [
        (-970 + 29j, 2.5 + 1.8j, 0.003 - 0.001j),
        (-970 + 29j, -2.5 + 1.8j, 0.02j),
        (300 - 280j, -0.4 + 0.5j, 0.01),
        (-970 + 29j, 1.8j, 0.02),
        (3j, 0.5 + 1j, 0.02),
        (3j, 1j, 0.02),
    ],
)
def test_the_closed_form_solves_the_amplitude_equation(alpha, sigma, A0):
    t = np.linspace(0, 2, 9)
    A = stuart_landau(alpha, sigma, A0, t)

    def rate(t: float, z: np.ndarray) -> np.ndarray:
        return (alpha * np.abs(z) ** 2 + sigma) * z

    numeric = solve_ivp(rate, (0, 2), [complex(A0)], "DOP853", t_eval=t, rtol=1e-12, atol=1e-15).y[0]
    np.testing.assert_allclose(A, numeric, rtol=1e-9)


def test_it_ends_at_the_fixed_amplitude_without_overflow():
    A = stuart_landau(-100 + 5j, 2 + 1j, 1e-3, np.array([0.0, 1e4]))
    assert abs(A[1]) == pytest.approx(np.sqrt(0.02), rel=1e-12)
    assert stuart_landau(-100, 2, 0.0, [1.0]) == 0


def test_it_decays_to_nothing_without_overflow():
    t = np.array([1e-3, 1.0, 1e3])
    A = stuart_landau(-2 + 1j, -900 + 30j, 0.01, t)
    assert A[1:].tolist() == [0, 0]
    assert A[0] == pytest.approx(0.01 * np.exp((-900 + 30j) * 1e-3), rel=1e-6)
    assert stuart_landau(5j, -900, 0.01, t)[2] == 0
    with pytest.raises(InputError, match="starts at t = 0, not at t = -1"):
        stuart_landau(-2, -900, 0.01, [0.0, -1.0])


def test_a_subcritical_amplitude_that_runs_away_is_refused_with_its_time():
    """b = 100, a = −1: from ρ0 = 0.02, twice the unstable value, 1/ρ reaches 0 at t = ln 2/2."""
    assert abs(stuart_landau(100, -1, np.sqrt(0.02), 0.34)) > 0.5
    with pytest.raises(ComputationError, match=r"every bound at t = 0\.3466"):
        stuart_landau(100, -1, np.sqrt(0.02), [0.1, 0.35])
    with pytest.raises(ComputationError, match=r"every bound at t = 0\.25"):
        stuart_landau(100, 1j, np.sqrt(0.02), [1.0])


@pytest.mark.parametrize(("rod", "index"), [(FIRST, 0), (REENTRANT, 0), (REENTRANT, 1)])
def test_shapes_solve_the_exact_equations_up_to_third_order(rod, index):
    """At the threshold: what remains falls like A³; without x of second order like A²."""
    c = landau(rod)[index]
    model = reduced_model(rod, repr(c.force), c)
    form = angle_form(rod, c.force, model.u.size - 1)
    d = chebyshev(model.u.size - 1).first

    def state(A: float, t: float) -> np.ndarray:
        x, y, theta, _ = model.reconstruct(A, t)
        cos, sin = np.cos(theta), np.sin(theta)
        x_u, y_u = d @ x, d @ y
        return form.state(cos * x_u + sin * y_u, cos * y_u - sin * x_u, theta)

    def defect(A: float) -> float:
        t, step = 0.3 / c.omega, 1e-4 / c.omega
        rate = (state(A, t + step) - state(A, t - step)) / (2 * step)
        # compared as displacements, by the slowest rates: f is stiff
        J = form.jacobian(np.zeros(form.size))
        return float(np.abs(np.linalg.solve(J, rate - form.rhs(state(A, t)))).max())

    order = np.log2(defect(2e-4) / defect(1e-4))
    assert order == pytest.approx(3, abs=0.1)


def test_a_perturbation_along_the_mode_has_its_amplitude():
    model = reduced_model(FIRST, 38)
    A = 0.003 - 0.002j
    y, theta = 2 * (A * model.Y).real, 2 * (A * model.Theta).real
    assert model.amplitude(y, theta) == pytest.approx(A, rel=1e-9)


def test_the_transient_ends_at_the_prediction():
    model = reduced_model(FIRST, 38)
    assert model.coefficients.force == pytest.approx(37.66, abs=0.01)
    expected = predict_at(model.coefficients, 38.0)
    A = model.transient(0.001, [8.0, 8.0 + 1e-3])
    assert 2 * abs(A[0]) == pytest.approx(expected.A_tip, rel=1e-9)
    drift = np.angle(A[1] / A[0]) / 1e-3
    assert model.coefficients.omega + drift == pytest.approx(expected.omega, rel=1e-9)
    tip = model.reconstruct(A[0], 8.0)[1][-1]
    assert tip == pytest.approx(2 * (A[0] * np.exp(8j * model.coefficients.omega)).real, rel=1e-9)


def test_close_to_the_threshold_it_follows_the_full_rod_through_the_transient():
    run = simulate(FIRST, "37.7", "0.5", "5e-3")
    model = reduced_model(FIRST, "37.7")
    wave = 5e-3 * np.sin(np.pi * model.u / 2)
    A = model.transient(model.amplitude(wave, wave), run.time)
    y = model.reconstruct(A, run.time)[1][:, -1]
    later = run.time > 0.05
    assert np.abs(y - run.tip_y)[later].max() < 0.01 * np.abs(y[later]).max()


@pytest.mark.parametrize(
    ("model", "values"),
    [
        *(
            ("metric_drag", (200, 1e4, 1e-4)),
            ("quartic", (200, 1e4, 1e-4)),
            ("distributed", (1e4, 1e4, 1e-4)),
        ),
        (LOADED, (200, 1e2, 1e-2)),
    ],
)
def test_shapes_of_another_rod_part_from_its_orbit_with_the_next_order(model, values):
    """y and θ with the third power of the amplitude, x and the axial force with the fourth."""
    rod = RodParameters(*values, model=emitted(model))
    c = landau(rod)[0]
    law, tau = emitted_law(rod), 2 * np.pi * np.arange(16) / 16

    def gaps(detuning: float) -> np.ndarray:
        force = c.force * (1 + detuning)
        cycle = periodic_orbits(rod, force).orbits[0].cycle
        phase = np.angle(np.fft.rfft(cycle.shape(tau)[1][:, -1])[1])
        reduced = reduced_model(rod, repr(force), c)
        x, y, theta, F1 = reduced.reconstruct(
            np.sqrt(c.A_tip2_slope * (force - c.force)) / 2 * np.exp(1j * tau), 0.0
        )
        full_x, full_y, full_theta = cycle.shape(tau - phase, reduced.u)
        d = chebyshev(reduced.u.size - 1).first.T
        cos, sin, x_u, y_u = np.cos(full_theta), np.sin(full_theta), full_x @ d, full_y @ d
        stress = law.stress(cos * x_u + sin * y_u, cos * y_u - sin * x_u, full_theta @ d)[0]
        pairs = ((x, full_x), (y, full_y), (theta, full_theta), (F1, stress))
        return np.array([np.abs(a - b).max() for a, b in pairs])

    orders = np.log2(gaps(2e-3) / gaps(1e-3)) * 2  # the amplitude squared is proportional to the detuning
    np.testing.assert_allclose(orders, [4, 3, 3, 4], atol=0.1)


def test_it_follows_another_rod_through_its_transient(capsys):
    """From the perturbation to the settled beat, and in the command."""
    rod = RodParameters(200, "1e4", "1e-4", model="metric_drag")
    values = ["--k1", "200", "--k2", "1e4", "--gamma3", "1e-4", "--model", "metric-drag"]
    run = simulate(rod, "49.85", "0.15", "5e-3", rtol=1e-6)
    model = reduced_model(rod, "49.85")
    wave = 5e-3 * np.sin(np.pi * model.u / 2)
    A = model.transient(model.amplitude(wave, wave), run.time)
    y = model.reconstruct(A, run.time)[1][:, -1]
    later = run.time > 0.05
    assert np.abs(y - run.tip_y)[later].max() < 0.01 * np.abs(y[later]).max()
    assert cli.run(["simulate", *values, "--force", "49.85", "--time", "0.15", "--reduced", "--json"]) == 0
    document = json.loads(capsys.readouterr().out)
    assert document["model"] == "metric_drag"
    full, reduced = (float(document[name]["growth"]) for name in ("simulation", "reduced_model"))
    assert reduced == pytest.approx(full, rel=0.05)


def test_a_rod_without_threshold_is_refused_before_it_is_simulated(monkeypatch, capsys):
    monkeypatch.setattr("rodwnl.simulation.simulate", lambda *_: pytest.fail("was simulated"))
    rod = ["--k1", "10", "--k2", "1e4", "--gamma3", "1e-4"]
    assert cli.run(["simulate", *rod, "--force", "5", "--reduced"]) == 2
    assert "has no Hopf threshold" in capsys.readouterr().err


def test_an_amplitude_that_runs_away_does_not_discard_the_run(capsys):
    """Above its upper threshold the reentrant rod is bistable, and α drives."""
    rod = ["--k1", "200", "--k2", "1e4", "--gamma3", "1e-4", "--nodes", "12", "--rtol", "1e-4"]
    run = ["simulate", *rod, "--force", "157", "--perturbation", "0.6", "--time", "0.02", "--reduced"]
    assert cli.run(run) == 0
    assert "reduced model   leaves every bound" in capsys.readouterr().out
    assert cli.run([*run, "--json"]) == 0
    assert json.loads(capsys.readouterr().out)["reduced_model"] == {"state": "leaves every bound"}


def test_a_rod_without_threshold_is_refused():
    with pytest.raises(InputError, match="has no Hopf threshold"):
        reduced_model(RodParameters(2, 2, "1e-4"), 1)
