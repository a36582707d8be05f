"""The reduced model in use: one complex amplitude in place of the rod.

Near a Hopf threshold (F_c, ω_c) the rod moves, through second order in ε (paper: eq:solutionlinear,
eq:longitudinalODE, eq:pdefinitions; A includes the factor ε, so that F − F_c stands for ε²Δ), as

    y = A Y e^{iω_c t} + c.c.,    θ = A Θ e^{iω_c t} + c.c.,
    x = x̂ + A² X2 e^{2iω_c t} + |A|² X0 + c.c.,    F1 = F̂1 + A² P2 e^{2iω_c t} + |A|² P0 + c.c.,

with x̂ and F̂1 of the straight rod at the actual force (νu, ν = 1 − F/k1, and −F for the plain rod), and
dA/dt = α|A|²A + β(F − F_c)A (eq:SL), whose solution is elementary.
"""

from __future__ import annotations

from dataclasses import dataclass
from fractions import Fraction
from typing import Any

import numpy as np
from numpy.polynomial.legendre import legvander
from numpy.typing import ArrayLike, NDArray

from rodwnl.coefficients import LandauCoefficients, landau
from rodwnl.collocation import chebyshev
from rodwnl.errors import ComputationError, InputError
from rodwnl.modes import adjoint_mode, critical_mode, nodes_at, second_order
from rodwnl.parameters import PLAIN, Number, RodParameters, require_kind, require_rod
from rodwnl.quadrature import Nodes
from rodwnl.spectrum import DEFAULT_MAX_FORCE
from rodwnl.straightrod import straight_rod
from rodwnl.strainform import integrals

Array = NDArray[np.float64]
Complex = NDArray[np.complex128]

Named = dict[str, Any]

ADJOINT = ("Psi_Y", "Psi_Theta")
POINTS = 32  # degree of the Chebyshev points at which shapes are given


@dataclass(frozen=True)
class ReducedModel:
    """The rod at one force, expanded about one threshold. Built by `reduced_model`.

    Lengths in L, times in γ2 L⁴/k3, forces in k3/L². u (n,): points of the rod. straight_x, straight_tension
    (n,): position and axial force of the straight rod under the force. Y, Theta, Psi_Y, Psi_Theta, X0, X2,
    P0, P2 (n,): mode, adjoint mode and corrections there; Y(1) = 1, (Ψ, Φ)_Γ = 1 (eq:inner product), with the
    drag of a load at the tip in it (Psi_Y_tip, Psi_Theta_tip: the adjoint mode at u = 1).
    """

    rod: RodParameters
    coefficients: LandauCoefficients
    force: float
    u: Array
    straight_x: Array
    straight_tension: Array
    Y: Complex
    Theta: Complex
    Psi_Y: Complex
    Psi_Theta: Complex
    X0: Complex
    X2: Complex
    P0: Complex
    P2: Complex
    Psi_Y_tip: complex
    Psi_Theta_tip: complex

    def reconstruct(self, A: ArrayLike, t: ArrayLike) -> tuple[Array, Array, Array, Array]:
        """x, y, θ, F1 at the points u, (…, n) each, for amplitudes A (…) at times t (…)."""
        A, t = np.broadcast_arrays(np.asarray(A, complex), np.asarray(t, float))
        first = (A * np.exp(1j * self.coefficients.omega * t))[..., None]
        second, mean = first**2, np.abs(first) ** 2
        x = self.straight_x + 2 * (second * self.X2 + mean * self.X0).real
        y, theta = 2 * (first * self.Y).real, 2 * (first * self.Theta).real
        return x, y, theta, self.straight_tension + 2 * (second * self.P2 + mean * self.P0).real

    def amplitude(self, y: Array, theta: Array) -> complex:
        """The amplitude of a small perturbation (y, θ), (n,) each, at t = 0: its share of the mode.

        A = (Ψ, (y, θ))_Γ; the conjugate mode, orthogonal to Ψ, does not contribute.
        """
        given = {
            name: getattr(self, name) for name in ("u", "Psi_Y", "Psi_Theta", "Psi_Y_tip", "Psi_Theta_tip")
        }
        given |= {"Y": y, "Theta": theta, "Y_tip": y[-1], "Theta_tip": theta[-1]}
        return _paired(self.rod, self.coefficients.force, chebyshev(self.u.size - 1).weights, given)

    def transient(self, A0: complex, t: ArrayLike) -> Complex:
        """A(t) from A(0) = A0, of the shape of t >= 0. See `stuart_landau`."""
        c = self.coefficients
        return stuart_landau(c.alpha, c.beta * (self.force - c.force), A0, t)


def reduced_model(
    rod: RodParameters, force: Number, coefficients: LandauCoefficients | None = None
) -> ReducedModel:
    """The amplitude equation and its shapes at a force, about a threshold (default: the nearest).

    Raises InputError for a force without straight rod and for a rod without threshold, and what `landau`
    raises.
    """
    require_rod(rod)
    exact = rod.checked_force(force)
    if coefficients is not None:
        require_kind("coefficients", coefficients, LandauCoefficients, "one of those that `landau` finds")
    else:
        found = landau(rod, max(exact, Fraction(DEFAULT_MAX_FORCE)))
        if not found.thresholds:
            raise InputError(f"{rod} has no Hopf threshold, so there is nothing to reduce it to")
        coefficients = min(found, key=lambda c: abs(c.force - float(exact)))
    nodes, fields, tips = _shapes(rod, coefficients.force, coefficients.omega)
    norm = np.conj(_paired(rod, coefficients.force, nodes.weights, {"u": nodes.u, **fields, **tips}))
    points = chebyshev(max(POINTS, nodes.u.size)).nodes
    straight, to_points = straight_rod(rod, float(exact)), interpolation(nodes, points)
    nu = np.broadcast_to(straight.stretch(points)[0], points.shape)
    return ReducedModel(
        rod, coefficients, float(exact), points,
        straight_x=integrals(points.size - 1).up @ nu,
        straight_tension=np.broadcast_to(straight("stresses", h1=nu, h2=0.0, Pi=0.0)[0], points.shape),
        **{name: to_points @ (field / norm if name in ADJOINT else field) for name, field in fields.items()},
        **{f"{name}_tip": tips[f"{name}_tip"] / norm for name in ADJOINT},
    )  # fmt: skip


def _shapes(rod: RodParameters, force: float, omega: float) -> tuple[Nodes, Named, Named]:
    """Nodes; mode, adjoint mode and corrections there by name; the modes at the tip."""
    if rod.model == PLAIN:
        at = rod.floats(), force, omega
        nodes = nodes_at(*at)
        mode, adjoint = critical_mode(*at, nodes), adjoint_mode(*at, nodes)
        X = second_order(*at, mode, nodes)
        known = vars(mode) | vars(adjoint) | vars(X) | {"Y_tip": 1.0}
        known["Psi_Theta_tip"] = 0j  # nothing asks for it: the plain rod's load has no drag
    else:
        from rodwnl import expansion, thresholds  # SciPy, which the plain rod does not need

        nodes, straight = thresholds.nodes_at(rod, force, omega), straight_rod(rod, force)
        of_rod = expansion.critical_mode(straight, omega, nodes)
        known = of_rod.named() | expansion.second_order(straight, omega, of_rod, nodes)[0]
    fields = {name: known[name] for name in ("Y", "Theta", *ADJOINT, "X0", "X2", "P0", "P2")}
    return nodes, fields, {f"{name}_tip": known[f"{name}_tip"] for name in ("Y", "Theta", *ADJOINT)}


def _paired(rod: RodParameters, force: float, weights: Array, given: Named) -> complex:
    """(Ψ, (Y, Θ))_Γ of the rod at its threshold, with what a load with drag adds at the tip."""
    straight = straight_rod(rod, force)
    integrand = np.broadcast_to(straight("norm_integrand", **given), weights.shape)
    return complex(weights @ integrand + straight("norm_boundary", **given))


def stuart_landau(alpha: complex, sigma: complex, A0: complex, t: ArrayLike) -> Complex:
    """The solution of dA/dt = α|A|²A + σA, A(0) = A0, at times t >= 0 (eq:SL with σ = β(F − F_c)).

    ρ = |A|² obeys dρ/dt = 2(Re σ + Re α ρ) ρ, so with a = Re σ, b = Re α

        ρ0/ρ = e^{−2at} − bρ0 (1 − e^{−2at})/a = e^{−2at} (1 − q),    q = bρ0 (e^{2at} − 1)/a,
        arg A = arg A0 + Im σ t + Im α ∫ρ,    b ∫ρ = ½ ln(ρ/ρ0) − at = −½ ln(1 − q),

    the first form for a > 0, the second else, so that no exponential grows. Raises InputError for a negative
    time, ComputationError where A becomes infinite before the last time, as it can for Re α > 0.
    """
    t = np.asarray(t, float)
    if (t < 0).any():
        raise InputError(f"the amplitude equation starts at t = 0, not at t = {t.min():.6g}")
    a, b, rho0 = sigma.real, alpha.real, abs(A0) ** 2
    if rho0 == 0:
        return np.zeros(t.shape, complex)
    if a > 0:
        share = np.exp(-2 * a * t) + b * rho0 * np.expm1(-2 * a * t) / a  # ρ0/ρ
        leaves = (share <= 0).any()
    else:
        grown = np.expm1(2 * a * t) / a if a else 2 * t
        leaves = (b * rho0 * grown >= 1).any()
    if leaves:
        blow_up = -np.log1p(-a / (a + b * rho0)) / (2 * a) if a else 1 / (2 * b * rho0)
        raise ComputationError(
            f"the amplitude equation leaves every bound at t = {blow_up:.4g}: from |A| = {abs(A0):.3g} the "
            "cubic term drives it out of its range, where only the full rod can tell what follows"
        )
    if a > 0:
        log_growth = -np.log(share) / 2  # ln(|A|/|A0|)
        integral = (log_growth - a * t) / b if b else rho0 * np.expm1(2 * a * t) / (2 * a)
    else:
        less = np.log1p(-b * rho0 * grown) / 2
        log_growth, integral = a * t - less, -less / b if b else rho0 * grown / 2
    return np.asarray(A0 * np.exp(log_growth + 1j * (sigma.imag * t + alpha.imag * integral)))


def interpolation(nodes: Nodes, points: Array) -> Array:
    """(len(points), len(nodes.u)): values at Gauss–Legendre nodes -> of their polynomial at the points."""
    k = np.arange(nodes.u.size)
    series = (2 * k[:, None] + 1) * legvander(2 * nodes.u - 1, nodes.u.size - 1).T * nodes.weights
    return np.asarray(legvander(2 * points - 1, nodes.u.size - 1) @ series)
