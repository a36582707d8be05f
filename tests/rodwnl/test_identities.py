"""Identities of the theory on rods that hypothesis draws, evaluated exactly: no tolerance but rounding."""

from dataclasses import replace

import mpmath as mp
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from rodwnl.closedform import adjoint_mode, coefficients, critical_mode, critical_state, second_order
from rodwnl.exact import MpNumbers, exact_threshold
from rodwnl.parameters import RodParameters
from rodwnl.spectrum import hopf_thresholds

DIGITS = 40
TINY = mp.mpf(10) ** -25
few = settings(
    max_examples=8,
    deadline=None,
    derandomize=True,
    suppress_health_check=[HealthCheck.function_scoped_fixture],
)


@pytest.fixture(autouse=True)
def _working_digits():
    with mp.workdps(DIGITS):
        yield


def decade(low, high):
    """A decimal text, uniform in the logarithm."""
    return st.floats(low, high).map(lambda x: f"{10**x:.3g}")


# Stiff enough in stretch that a threshold exists well below F = k1.
rods = st.builds(RodParameters, decade(2.2, 7), decade(1, 7), decade(-7, 0), decade(-1.2, 0.3))


def state_of(rod):
    (first, *_) = hopf_thresholds(rod)
    found = exact_threshold(rod, first.force, first.omega, 30)
    with mp.workdps(found.working_digits):
        return critical_state(rod, found.force, found.omega, MpNumbers()), found


@few
@given(rods, st.complex_numbers(min_magnitude=0.1, max_magnitude=10))
def test_another_size_and_phase_of_the_mode(rod, factor):
    """Y → cY: α → |c|²α, β stays; the adjoint's own factor drops out."""
    state, found = state_of(rod)
    with mp.workdps(found.working_digits):
        c = mp.mpmathify(factor)
        mode, adjoint = critical_mode(state), adjoint_mode(state)
        scaled = replace(mode, **{n: getattr(mode, n) * c for n in ("Y", "Theta", "Theta_u", "H")})
        other = replace(adjoint, Psi_Y=adjoint.Psi_Y * (2 - 3j), Psi_Theta=adjoint.Psi_Theta * (2 - 3j))
        alpha, beta = by_hand(state, scaled, other)
        assert abs(alpha / (abs(c) ** 2 * found.alpha) - 1) < TINY
        assert abs(beta / found.beta - 1) < TINY


def by_hand(state, mode, adjoint):
    """α and β of a mode in any normalisation."""
    X, Psi = second_order(state, mode), {"Psi_Y": adjoint.Psi_Y, "Psi_Theta": adjoint.Psi_Theta}
    known = mode.named() | {"X2": X.X2, "P0": X.P0, "P2": X.P2, "u": state.exponents.u(mp.mpf(1))}
    g = {name: state(name, **known) for name in ("g1", "g2", "g3", "g4")}
    norm = state("norm_integrand", **Psi, **mode.named()).integral()
    alpha = state("alpha_integrand", **Psi, **g).integral() / norm
    return alpha, state("beta_integrand", **Psi, **g).integral() / norm


@few
@given(rods)
def test_modes_of_different_eigenvalues_are_orthogonal(rod):
    """(Ψ, Φ*)_Γ = 0: Ψ belongs to iω, Φ* to −iω."""
    state, found = state_of(rod)
    with mp.workdps(found.working_digits):
        mode, adjoint = critical_mode(state), adjoint_mode(state)
        Psi = {"Psi_Y": adjoint.Psi_Y, "Psi_Theta": adjoint.Psi_Theta}
        own = state("norm_integrand", **Psi, Y=mode.Y, Theta=mode.Theta).integral()
        mirrored = {"Y": mode.Y.conjugate(), "Theta": mode.Theta.conjugate()}
        other = state("norm_integrand", **Psi, **mirrored).integral()
        size = abs(mode.Y(mp.mpf(1) / 2)) * abs(adjoint.Psi_Y(mp.mpf(1) / 2)) + abs(own)
        assert abs(other) < TINY * size
        assert abs(own) > 0


@few
@given(rods)
def test_beta_is_the_slope_of_the_eigenvalue(rod):
    """(Ψ, ∂_F L Φ) in integral form against −D_F/D_λ of the float64 spectrum."""
    first = hopf_thresholds(rod)[0]
    found = exact_threshold(rod, first.force, first.omega, 15)
    assert abs(mp.mpmathify(first.slope) / found.beta - 1) < 1e-6


@few
@given(rods)
def test_two_routes_to_alpha_and_beta(rod):
    """With transformed variables, and with the boundary term kept."""
    state, found = state_of(rod)
    with mp.workdps(found.working_digits):
        residuals = coefficients(state).residuals
        assert residuals["alpha_routes"] < TINY
        assert residuals["beta_routes"] < TINY


@few
@given(rods, decade(-3, 3), decade(-3, 3), decade(-3, 3))
def test_dimensional_rods_have_the_same_numbers(rod, L, k3, gamma2):
    """from_physical(…) and back: the same dimensionless rod, its scales L, γ2L⁴/k3 and k3/L²."""
    length, bending, drag = (RodParameters(x, 1, 1).k1 for x in (L, k3, gamma2))
    scale = bending / length**2
    physical = RodParameters.from_physical(
        L, rod.k1 * scale, rod.k2 * scale, k3, rod.gamma1 * drag, gamma2, rod.gamma3 * drag * length**2
    )
    assert [getattr(physical, n) for n in ("k1", "k2", "gamma3", "gamma1")] == [
        getattr(rod, n) for n in ("k1", "k2", "gamma3", "gamma1")
    ]
    assert physical.scales.length == length
    assert physical.scales.force == scale
    assert physical.scales.time == drag * length**4 / bending
