"""Fields at a threshold: conditions, equations by differentiation, corrections, conditioning."""

import numpy as np
import pytest

from rodwnl import ComputationError, RodParameters, hopf_thresholds, kernels
from rodwnl.modes import adjoint_mode, critical_mode, nodes_at, second_order, two_point
from rodwnl.quadrature import gauss_legendre

RODS = [(1e4, 1e4, 1e-4, 0.5), (1e4, 1e2, 1e-2, 0.5), (200.0, 1e4, 1e-4, 0.5), (1e8, 1e8, 1e-8, 2.0)]


@pytest.fixture(params=RODS, ids=str)
def point(request):
    threshold = hopf_thresholds(RodParameters(*request.param))[-1]
    return request.param, threshold.force, threshold.omega


def derivative(nodes, values):
    """Of the polynomial through the values: the inverse of ∫ᵤ¹, whose value at the tip is extrapolated."""
    legendre = np.polynomial.legendre
    series = legendre.legfit(2 * nodes.u - 1, values, len(nodes.u) - 8)
    return 2 * legendre.legval(2 * nodes.u - 1, legendre.legder(series))


def at(u, nodes, values):
    """The value at u of the polynomial through the values."""
    legendre = np.polynomial.legendre
    return legendre.legval(2 * u - 1, legendre.legfit(2 * nodes.u - 1, values, len(nodes.u) - 8))


def small(value, *terms):
    return np.max(np.abs(value)) < 1e-9 * max(np.max(np.abs(term)) for term in terms)


def test_the_mode_satisfies_its_equations_and_conditions(point):
    parameters, force, omega = point
    k1, k2, gamma3, _ = parameters
    nu, mu = kernels.base_state(k1, k2, force)
    nodes = nodes_at(*point)
    m = critical_mode(*point, nodes)
    assert m.boundary_residual < 1e-13
    assert m.ode_residual < 1e-13
    for field in (m.Y, m.Theta):
        assert abs(at(0.0, nodes, field)) < 1e-11
    assert at(1.0, nodes, m.Y) == pytest.approx(1, abs=1e-11)
    assert at(1.0, nodes, m.Theta) == pytest.approx(m.Theta_tip, rel=1e-11)
    assert small(at(1.0, nodes, m.H), m.H)
    assert small(at(1.0, nodes, m.Theta_u), m.Theta_u)
    assert small(derivative(nodes, m.Y) - nu * m.Theta - m.H, m.Theta)
    assert small(derivative(nodes, m.Theta) - m.Theta_u, m.Theta_u)
    balance = k2 * derivative(nodes, m.H) - force * m.Theta_u - 1j * omega * m.Y
    assert small(balance, force * m.Theta_u)
    moments = derivative(nodes, m.Theta_u) + mu * m.H - gamma3 * 1j * omega * m.Theta
    assert small(moments, mu * m.H)


def test_the_adjoint_satisfies_its_conditions(point):
    parameters, force, _ = point
    k1, k2, *_ = parameters
    _, mu = kernels.base_state(k1, k2, force)
    nodes = nodes_at(*point)
    a = adjoint_mode(*point, nodes)
    assert a.boundary_residual < 1e-13
    assert a.ode_residual < 1e-13
    slope_Y, slope_Theta = derivative(nodes, a.Psi_Y), derivative(nodes, a.Psi_Theta)
    assert abs(at(0.0, nodes, a.Psi_Y)) < 1e-11
    assert small(at(0.0, nodes, a.Psi_Theta), a.Psi_Theta)
    assert small(at(1.0, nodes, k2 * slope_Y - mu * a.Psi_Theta), k2 * slope_Y)
    assert small(at(1.0, nodes, slope_Theta) + force * a.Psi_Y_tip, slope_Theta)
    assert np.max(np.abs(a.Psi_Y)) == pytest.approx(1)


def test_the_corrections_satisfy_their_two_point_problems(point):
    parameters, force, omega = point
    k1, k2, _, gamma1 = parameters
    nodes, lam = nodes_at(*point), 1j * omega
    m = critical_mode(*point, nodes)
    X = second_order(*point, m, nodes)
    assert X.residual < 1e-13
    fields = m.Y, m.Theta, m.Theta_u, m.H
    for field, operator, forcing, slope in (
        (X.X0, kernels.X0_operator(), kernels.X0_forcing, kernels.X0_tip_slope),
        (X.X2, kernels.X2_operator(lam, gamma1), kernels.X2_forcing, kernels.X2_tip_slope),
    ):
        first = derivative(nodes, field)
        data = forcing(*fields, lam, k1, k2, gamma1, force)
        assert small(k1 * derivative(nodes, first) - operator * field - data, data)
        assert abs(at(0.0, nodes, field)) < 1e-11 * np.max(abs(field))
        assert at(1.0, nodes, first) == pytest.approx(slope(m.Theta_tip, k1, force), rel=1e-9)
    for tension in (X.P0, X.P2):
        assert small(at(1.0, nodes, tension), tension)


@pytest.mark.parametrize("k1", [1.0, 1e8])
@pytest.mark.parametrize("sigma", [3 + 4j, 1e-6 + 0j, -20 + 20j])
def test_a_resonant_forcing_of_the_two_point_problem_is_no_trouble(k1, sigma):
    # X = u e^{σu} solves k1 X'' = k1σ² X + 2k1σ e^{σu}: the forcing is a solution without forcing
    nodes = gauss_legendre(64)
    forcing = 2 * k1 * sigma * np.exp(sigma * nodes.u)
    field, slope = two_point(k1, k1 * sigma**2, forcing, (1 + sigma) * np.exp(sigma), nodes)
    assert field == pytest.approx(nodes.u * np.exp(sigma * nodes.u), rel=1e-11)
    assert slope == pytest.approx((1 + sigma * nodes.u) * np.exp(sigma * nodes.u), rel=1e-11)


def test_more_nodes_change_nothing(point):
    count = len(nodes_at(*point).u)
    few, many = gauss_legendre(count), gauss_legendre(2 * count)
    here, there = critical_mode(*point, few), critical_mode(*point, many)
    assert here.Theta_tip == pytest.approx(there.Theta_tip, rel=1e-13)
    assert few.weights @ abs(here.Y) ** 2 == pytest.approx(many.weights @ abs(there.Y) ** 2, rel=1e-13)


def test_layers_too_thin_for_the_quadrature_are_refused():
    with pytest.raises(
        ComputationError, match=r"vary like exp\(3.16e\+03 u\): 6.35e\+03 nodes would be needed"
    ):
        nodes_at((1e4, 1e4, 1.0, 0.5), 30.0, 1e7)
