"""Identities of the weakly nonlinear theory: gauge, two solvability conditions, β = dλ/dF, units."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from rodwnl import RodParameters, kernels, landau
from rodwnl.modes import adjoint_mode, critical_mode, nodes_at, second_order

PAPER = [(10000, 10000, "1e-4"), (10000, 100, "1e-2"), (200, 10000, "1e-4")]
REENTRANT = RodParameters(200, 10000, "1e-4")


def decades(low, high):
    return st.floats(np.log10(low), np.log10(high)).map(lambda x: float(10**x))


class Coefficients:
    """α and β from the emitted integrands, with a mode and an adjoint that may be rescaled."""

    def __init__(self, rod, threshold, mode_scale=1.0, adjoint_scale=1.0):
        self.parameters, self.force, self.omega = rod.floats(), threshold.force, threshold.omega
        self.nodes = nodes_at(self.parameters, self.force, self.omega)
        args = self.parameters, self.force, self.omega
        mode, adjoint = critical_mode(*args, self.nodes), adjoint_mode(*args, self.nodes)
        s, a = mode_scale, adjoint_scale
        self.mode = replace(
            mode, Y=s * mode.Y, Theta=s * mode.Theta, Theta_u=s * mode.Theta_u, H=s * mode.H,
            Theta_tip=s * mode.Theta_tip,
        )  # fmt: skip
        self.adjoint = replace(
            adjoint, Psi_Y=a * adjoint.Psi_Y, Psi_Theta=a * adjoint.Psi_Theta, Psi_Y_tip=a * adjoint.Psi_Y_tip
        )
        self.X = second_order(*args, self.mode, self.nodes)
        self.Psi = self.adjoint.Psi_Y, self.adjoint.Psi_Theta
        self.norm = self.integral(
            kernels.norm_integrand(*self.Psi, self.mode.Y, self.mode.Theta, self.parameters[2])
        )

    def integral(self, integrand):
        return self.nodes.weights @ integrand

    def transformed(self):
        k1, k2, _, gamma1 = self.parameters
        m, X, lam = self.mode, self.X, 1j * self.omega
        g1 = kernels.g1(m.Y, m.Theta, m.Theta_u, m.H, X.X2, X.P0, X.P2, lam, k1, k2, gamma1)
        g3 = kernels.g3(m.Theta, m.Theta_u, m.H, X.P0, X.P2, k1, k2, self.force)
        g2 = kernels.g2(self.nodes.u, m.Theta_u, m.Theta_tip, lam, k1, k2)
        g4 = kernels.g4(m.Theta, m.H, m.Theta_tip, k1, k2, self.force)
        alpha = self.integral(kernels.alpha_integrand(*self.Psi, g1, g3))
        beta = self.integral(kernels.beta_integrand(*self.Psi, g2, g4))
        return alpha / self.norm, beta / self.norm

    def untransformed(self):
        k1, k2, _, gamma1 = self.parameters
        m, X, tip = self.mode, self.X, self.adjoint.Psi_Y_tip
        shapes = m.Y, m.Theta, m.Theta_u, m.H, X.X2, X.P0, X.P2
        numbers = 1j * self.omega, k1, k2, gamma1, self.force
        alpha = self.integral(kernels.alpha_untransformed(*self.Psi, *shapes, *numbers))
        beta = self.integral(
            kernels.beta_untransformed(*self.Psi, m.Theta, m.Theta_u, m.H, k1, k2, self.force)
        )
        alpha += kernels.alpha_boundary(m.Theta_tip, tip, k1, k2, self.force)
        beta += kernels.beta_boundary(m.Theta_tip, tip, k1, k2)
        return alpha / self.norm, beta / self.norm


@pytest.mark.parametrize("mode_scale", [2.0, -1.0, 1j, 0.3 - 0.7j])
def test_alpha_scales_with_the_square_of_the_mode_and_beta_stays(mode_scale):
    for found in landau(REENTRANT):
        alpha, beta = Coefficients(REENTRANT, found, mode_scale, 3 - 2j).transformed()
        assert alpha == pytest.approx(abs(mode_scale) ** 2 * found.alpha, rel=1e-11)
        assert beta == pytest.approx(found.beta, rel=1e-11)


@pytest.mark.parametrize("rod", PAPER)
def test_transformed_variables_and_the_boundary_term_give_the_same_coefficients(rod):
    rod = RodParameters(*rod)
    for found in landau(rod):
        alpha, beta = Coefficients(rod, found).untransformed()
        assert alpha == pytest.approx(found.alpha, rel=1e-9)
        assert beta == pytest.approx(found.beta, rel=1e-9)


@settings(max_examples=25)
@given(decades(30, 1e8), decades(5, 1e8), decades(1e-8, 1), decades(0.05, 2))
def test_beta_is_the_slope_of_the_critical_eigenvalue(k1, k2, gamma3, gamma1):
    for found in landau(RodParameters(k1, k2, gamma3, gamma1), max_force=min(k1, 100)):
        assert abs(found.beta - found.threshold.slope) < 2 * found.beta_error + 1e-12 * abs(found.beta)


@settings(max_examples=10)
@given(decades(0.1, 10), decades(1e-3, 1e3), decades(1e-2, 1e2))
def test_coefficients_do_not_depend_on_the_units(length, k3, gamma2):
    rod = RodParameters.from_physical(
        L=length, k1=200 * k3 / length**2, k2=1e4 * k3 / length**2, k3=k3,
        gamma1=gamma2 / 2, gamma2=gamma2, gamma3=1e-4 * gamma2 * length**2,
    )  # fmt: skip
    for found, expected in zip(landau(rod), landau(REENTRANT), strict=True):
        assert found.force == pytest.approx(expected.force, rel=1e-12)
        assert found.alpha == pytest.approx(expected.alpha, rel=1e-10)
        assert found.omega_slope == pytest.approx(expected.omega_slope, rel=1e-9)
