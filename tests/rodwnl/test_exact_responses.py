"""Order 5 in closed form: against the quadrature route, and its particular solutions term by term."""

from dataclasses import replace

import mpmath as mp
import pytest

from rodwnl import InputError, RodParameters, exact_responses, landau
from rodwnl.errors import ComputationError
from rodwnl.exact import digits_agreed, same_texts
from rodwnl.exact_responses import _ExactResponses, exact_amplitude_equation
from rodwnl.responses import amplitude_equation


@pytest.fixture(scope="module")
def rod():
    return RodParameters("300", "150", "1e-2")


@pytest.fixture(scope="module")
def threshold(rod):
    return landau(rod)[0]


@pytest.fixture(scope="module")
def solver(rod, threshold):
    with mp.workdps(30):
        return _ExactResponses(rod, mp.mpf(threshold.force), mp.mpf(threshold.omega))


def test_agrees_with_the_quadrature_route(rod, threshold):
    exact = exact_amplitude_equation(rod, threshold.threshold.force, threshold.omega, 15)
    near = amplitude_equation(rod, threshold.threshold)
    for name, c in exact.coefficients.items():
        assert abs(near.coefficients[name] - complex(c)) <= 1e-10 * abs(complex(c)) + near.errors[name]
    assert near.A_tip2_curvature == pytest.approx(float(exact.A_tip2_curvature), rel=1e-9)
    assert near.omega_curvature == pytest.approx(float(exact.omega_curvature), rel=1e-9)
    assert near.third_harmonic == pytest.approx(complex(exact.third_harmonic), rel=1e-9)


@pytest.mark.parametrize("name", ["third_harmonic", "A_tip2_slope", "omega_slope", "omega"])
def test_every_number_must_agree(rod, threshold, monkeypatch, name):
    """One that never settles is not given out, whichever it is."""
    evaluate, calls = exact_responses._evaluate, []

    def unsettled(*arguments):
        calls.append(1)
        found = evaluate(*arguments)
        return replace(found, **{name: getattr(found, name) * (1 + mp.mpf(len(calls)) / 10**5)})

    monkeypatch.setattr(exact_responses, "_evaluate", unsettled)
    monkeypatch.setattr(exact_responses, "ATTEMPTS", 1)
    with pytest.raises(ComputationError, match="4 digits were not reached at order 5"):
        exact_amplitude_equation(rod, threshold.threshold.force, threshold.omega, 4)


def test_a_number_near_a_tie_is_not_rounded_by_agreement_alone():
    below, above = mp.mpf("1.24999999"), mp.mpf("1.25000001")
    assert digits_agreed([below], [above]) > 7
    assert not same_texts([below], [above], 2)


@pytest.mark.parametrize("harmonic", [1, 3])
def test_particular_solutions_solve_the_equations(solver, harmonic):
    """Terms u^p e^{au} with a general exponent, and with one of the homogeneous problem (a resonance)."""
    with mp.workdps(30):
        general, root = solver.exponents.key(1, 2), solver.exponents.key(solver.transverse_keys[harmonic][0])
        f = solver.exponents.field(
            {general: (mp.mpf(2), mp.mpc(1, 3)), root: (mp.mpf(1), mp.mpf(-2), mp.mpf(3))}
        )
        g = solver.exponents.field({root: (mp.mpc(0, 1),), general: (mp.mpf(5),)})
        lam = harmonic * solver.lam
        Y, Theta = solver._particular(lam, harmonic, f, g)
        Y_u, Theta_u = Y.derivative(), Theta.derivative()
        nu, mu = solver.straight("base_state")
        k2, gamma3 = (solver.straight.values[name] for name in ("k2", "gamma3"))
        y = lam * Y - k2 * Y_u.derivative() + mu * Theta_u - f
        theta = gamma3 * lam * Theta - Theta_u.derivative() - mu * (Y_u - nu * Theta) - g
        for u in (mp.mpf("0.3"), mp.mpf("0.9")):
            assert abs(y(u)) < mp.mpf(10) ** -20 * abs(f(u))
            assert abs(theta(u)) < mp.mpf(10) ** -20 * abs(f(u))


def test_digits_outside_the_range_are_refused(rod, threshold):
    with pytest.raises(InputError, match="digits"):
        exact_amplitude_equation(rod, threshold.threshold.force, threshold.omega, 0)
