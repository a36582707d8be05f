"""Identities of the linear problem: three forms of one spectrum, its adjoint, its limits."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from rodwnl import RodParameters, hopf_thresholds, kernels
from rodwnl.characteristic import characteristic, characteristic_slopes
from rodwnl.inverse import inverse_operator, leading_eigenvalues, unstable_count
from rodwnl.modes import adjoint_mode, critical_mode
from rodwnl.quadrature import gauss_legendre


def decades(low, high):
    return st.floats(np.log10(low), np.log10(high)).map(lambda x: float(10**x))


RODS = st.tuples(decades(20, 1e8), decades(20, 1e8), decades(1e-8, 1), decades(0.05, 2))
PARTS = st.floats(0.02, 0.95)  # of min(k1, 60): where the first crossings are

SOME = [(1e4, 1e4, 1e-4, 0.5), (1e4, 1e2, 1e-2, 0.5), (200.0, 1e4, 1e-4, 0.5), (91.0, 603.0, 0.43, 0.56)]


def fredholm(parameters, force, lam):
    """D(λ)/D(0) in closed form, the Fredholm determinant of 1 − λK.

    With a, b = (r1 ± r2)² and c(z) = (cosh√z − 1)/z it is

    1 + λ/(2 k2) {(1 + k2γ3) [c(a) + c(b)] + (μν + 2γ3λ) [c(a) − c(b)]/(r1 r2)}
    """
    k1, k2, gamma3, _ = parameters
    nu = 1 - force / k1
    mu = k2 * nu + force
    total = (lam * (1 + k2 * gamma3) - mu * force) / k2  # r1² + r2²
    product = np.sqrt(lam * (mu * nu + gamma3 * lam) / k2 + 0j)  # r1 r2
    a, b = total + 2 * product, total - 2 * product
    # (cosh √z − 1)/z = ½ (sinh(√z/2)/(√z/2))²
    ca, cb = (0.5 * (np.sinh(np.sqrt(z) / 2) / (np.sqrt(z) / 2)) ** 2 for z in (a, b))
    bracket = (1 + k2 * gamma3) * (ca + cb) + (mu * nu + 2 * gamma3 * lam) * (ca - cb) / product
    return 1 + lam / (2 * k2) * bracket


@settings(max_examples=30)
@given(RODS, PARTS)
def test_eigenvalues_of_the_inverse_are_zeros_of_the_closed_form(parameters, part):
    force = part * min(parameters[0], 60)
    (eigenvalues,), _ = leading_eigenvalues(parameters, np.array([force]))
    for lam in eigenvalues[:3]:
        h = 1e-4 * lam
        before, here, after = (fredholm(parameters, force, lam + k * h) for k in (-1, 0, 1))
        slope, curvature = abs(after - before) / 2, abs(after - 2 * here + before)
        # Where two eigenvalues nearly meet, only the curvature bounds the distance from the zero.
        error = 1e-4 * abs(here) / (slope + 1e-2 * curvature)
        assert error < 1e-8


@settings(max_examples=50)
@given(RODS, PARTS, st.floats(0.3, 3), decades(3, 1e4))
def test_the_boundary_columns_have_the_determinant_of_the_closed_form(parameters, part, angle, size):
    force, lam = part * min(parameters[0], 60), size * np.exp(1j * angle / 2)
    k1, k2, *_ = parameters
    _, mu = kernels.base_state(k1, k2, force)
    value, growth, size = characteristic(parameters, force, lam)
    factor = np.exp(growth) * mu**2 / (4 * k2)
    assert abs(factor * value + fredholm(parameters, force, lam)) < 1e-13 * abs(factor) * size


def winding(parameters, force, radius, points=4000):
    """Zeros of the closed form with Re λ > 0 and |λ| < radius, by the argument principle."""
    up = np.linspace(-1, 1, points)
    axis = 1j * radius * np.sign(up) * up**2
    arc = radius * np.exp(1j * np.pi / 2 * np.linspace(1, -1, points))
    values = fredholm(parameters, force, np.concatenate([axis, arc[1:]]))
    steps = np.angle(values[1:] / values[:-1])
    assert np.max(np.abs(steps)) < 1
    return -round(float(np.sum(steps)) / (2 * np.pi))


@pytest.mark.parametrize("parameters", SOME)
def test_unstable_eigenvalues_are_as_many_as_the_argument_principle_counts(parameters):
    counts = []
    for force in np.array([0.1, 0.3, 0.5, 0.7, 0.9]) * min(parameters[0], 300):
        assert unstable_count(parameters, force) == winding(parameters, force, 2e4)
        counts.append(unstable_count(parameters, force))
    assert max(counts) > 0


@pytest.mark.parametrize("parameters", SOME)
def test_eigenvalues_of_the_inverse_are_zeros_of_the_characteristic_function(parameters):
    force = 0.6 * min(parameters[0], 60)
    (eigenvalues,), (slopes,) = leading_eigenvalues(parameters, np.array([force]))
    oscillating = [(lam, slope) for lam, slope in zip(eigenvalues, slopes, strict=True) if lam.imag > 0]
    assert oscillating
    for lam, slope in oscillating[:1]:
        value, _, _ = characteristic(parameters, force, lam)
        by_force, by_lam = characteristic_slopes(parameters, force, lam)
        assert abs(value / by_lam) < 1e-9 * abs(lam)
        assert slope == pytest.approx(-by_force / by_lam, rel=1e-8)


@settings(max_examples=25)
@given(RODS)
def test_without_force_the_spectrum_is_real_and_negative(parameters):
    (eigenvalues,), _ = leading_eigenvalues(parameters, np.array([0.0]))
    leading = eigenvalues[:4]
    assert np.all(leading.real < 0)
    assert np.all(abs(leading.imag) < 1e-9 * abs(leading))


@pytest.mark.parametrize("parameters", SOME)
def test_the_adjoint_mode_is_orthogonal_to_every_other_mode(parameters):
    threshold = hopf_thresholds(RodParameters(*map(str, parameters)))[0]
    force, omega, count = threshold.force, threshold.omega, 48
    nodes = gauss_legendre(count)
    inverse, vectors = np.linalg.eig(inverse_operator(parameters, force, count))
    adjoint = adjoint_mode(parameters, force, omega, nodes)
    order = np.argsort(-abs(inverse))[:8]
    overlap = []
    for vector in vectors[:, order].T:
        Y, Theta = vector[:count], vector[count:] / np.sqrt(parameters[2])
        norm = kernels.norm_integrand(adjoint.Psi_Y, adjoint.Psi_Theta, Y, Theta, parameters[2])
        overlap.append(abs(nodes.weights @ norm) / (nodes.weights @ abs(norm)))
    critical = abs(1 / inverse[order] - 1j * omega) < 1e-6 * omega
    assert np.sum(critical) == 1
    overlap = np.array(overlap)
    assert np.all(overlap[~critical] < 1e-8)
    assert np.all(overlap[critical] > 1e-3)


@pytest.mark.parametrize("parameters", SOME)
def test_the_mode_is_the_eigenvector_of_the_inverse(parameters):
    threshold = hopf_thresholds(RodParameters(*map(str, parameters)))[0]
    nodes = gauss_legendre(48)
    mode = critical_mode(parameters, threshold.force, threshold.omega, nodes)
    field = np.concatenate([mode.Y, np.sqrt(parameters[2]) * mode.Theta])
    image = 1j * threshold.omega * inverse_operator(parameters, threshold.force, 48) @ field
    assert np.max(abs(image - field)) < 1e-9 * np.max(abs(field))


def test_stiff_rods_approach_the_inextensible_unshearable_filament_at_first_order():
    limit = np.array([37.695430840318579, 191.258635765253])
    departures = []
    for exponent in (5, 6, 7):
        threshold = hopf_thresholds(RodParameters(10**exponent, 10**exponent, f"1e-{exponent}"))[0]
        departures.append(abs(np.array([threshold.force, threshold.omega]) - limit))
    orders = np.log10(np.array(departures)[:-1] / np.array(departures)[1:])
    assert orders == pytest.approx(np.ones((2, 2)), abs=1e-3)
