r"""The Stuart-Landau equation in polar form and what it predicts.

dA/dT = alpha |A|^2 A + beta Delta A with A = R e^{i phi}. Dividing by e^{i phi}, the real part gives dR/dT
and the imaginary part R dphi/dT; the rest is algebra in the ring of (R, Delta, Re/Im alpha, Re/Im beta).
"""

from __future__ import annotations

from dataclasses import dataclass

from sympy import Expr, sqrt
from sympy.polys.rings import PolyElement

from derivation.jets import JetRing, jet_ring
from derivation.symbols import symbol


@dataclass(frozen=True)
class Amplitude:
    """Polar equations, the constant-modulus solution, its stability and the physical predictions.

    Attributes:
        ring: the ring of R, Delta and the parts of alpha and beta.
        radial: dR/dT (eq:radial_amplitude).
        phase: dphi/dT (eq:phase_amplitude).
        saturated: R*^2 as (numerator, denominator) (eq:saturated_amplitude).
        stability: d(dR/dT)/dR at R* (unnumbered display after eq:saturated_amplitude).
        sigma: dphi/dT at R* as (numerator, denominator) (eq:slow_frequency).
        tip_amplitude, frequency: A_tip and omega against force minus critical force
            (eq:tipamplitude, eq:tipfrequency).
        amplitude_slope, frequency_slope: d(A_tip^2)/dF and d omega/dF along the branch.
        amplitude_curvature, frequency_curvature: the coefficients of (F - F_c)^2 in A_tip^2 and omega, from
            the amplitude equation at order 5 and the tip's third harmonic.
        fold_polynomial: (c2, c1, c0) of c2 d^2 + c1 d + c0 = 0 for the detuning d of a fold of the branch.
        fold_modulus_squared: R^2 there.
    """

    ring: JetRing
    radial: PolyElement
    phase: PolyElement
    saturated: tuple[PolyElement, PolyElement]
    stability: PolyElement
    sigma: tuple[PolyElement, PolyElement]
    tip_amplitude: Expr
    frequency: Expr
    amplitude_slope: Expr
    frequency_slope: Expr
    amplitude_curvature: Expr
    frequency_curvature: Expr
    fold_polynomial: tuple[Expr, Expr, Expr]
    fold_modulus_squared: Expr


def amplitude_equations() -> Amplitude:
    """From the Stuart-Landau equation to A_tip(F) and omega(F)."""
    ring = jet_ring(["R", "Delta", "alpha_re", "alpha_im", "beta_re", "beta_im"])
    r, delta = ring["R"], ring["Delta"]
    alpha = ring["alpha_re"] + ring.i * ring["alpha_im"]
    beta = ring["beta_re"] + ring.i * ring["beta_im"]
    # A = R e^{i phi}: dA/dT e^{-i phi} = dR/dT + i R dphi/dT = alpha R^3 + beta Delta R.
    right = alpha * r**3 + beta * delta * r
    radial = ring.real(right)
    phase = ((right - radial) / ring.ring.domain(0, 1)).exquo(r)

    # dR/dT = R (c0 + c2 R^2) vanishes at R*^2 = -c0/c2.
    rate = radial.exquo(r)
    c2 = ring.coefficient(rate, r**2, [r])
    c0 = ring.coefficient(rate, ring.one, [r])
    saturated = (-c0, c2)
    # d/dR at R*: c0 + 3 c2 R*^2.
    stability = c0 + 3 * saturated[0]
    p2 = ring.coefficient(phase, r**2, [r])
    p0 = ring.coefficient(phase, ring.one, [r])
    sigma = (p0 * c2 + p2 * saturated[0], c2)

    detuning = symbol("detuning")
    r_squared = (-c0).as_expr().subs(symbol("Delta"), detuning) / c2.as_expr()
    slope = (sigma[0].as_expr() / sigma[1].as_expr()).subs(symbol("Delta"), 1).expand()
    a1 = (-c0).as_expr().subs(symbol("Delta"), 1) / c2.as_expr()
    curvatures = _curvatures(a1)
    # The tip moves by 2 epsilon R* cos(...), and epsilon^2 Delta is the force minus its critical value.
    return Amplitude(
        ring,
        radial,
        phase,
        saturated,
        stability,
        sigma,
        tip_amplitude=2 * sqrt(r_squared),
        frequency=symbol("omega") + slope * detuning,
        amplitude_slope=4 * r_squared / detuning,
        frequency_slope=slope,
        amplitude_curvature=curvatures[0],
        frequency_curvature=curvatures[1],
        fold_polynomial=_fold_polynomial(),
        fold_modulus_squared=_fold_modulus_squared(),
    )


def _growth() -> tuple[JetRing, PolyElement]:
    """Re (dA/dt)/A = (Re beta + Re beta2 d) d + (Re alpha + Re alpha' d) s + Re alpha5 s^2 with s = R^2."""
    ring = jet_ring(["s", "d", "alpha_re", "alpha1_re", "alpha5_re", "beta_re", "beta2_re"])
    s, d = ring["s"], ring["d"]
    linear = ring["beta_re"] * d + ring["beta2_re"] * d**2
    return ring, linear + (ring["alpha_re"] + ring["alpha1_re"] * d) * s + ring["alpha5_re"] * s**2


def _fold_modulus_squared() -> Expr:
    """At a fold d(growth)/ds = 0, which is linear in s."""
    ring, growth = _growth()
    s = ring["s"]
    slope = growth.diff(s)
    rest = ring.coefficient(slope, ring.one, [s]).as_expr()
    root = -rest / ring.coefficient(slope, s, [s]).as_expr()
    return root.subs(symbol("d"), symbol("detuning"))


def _fold_polynomial() -> tuple[Expr, Expr, Expr]:
    """growth = 0 = d(growth)/ds: the discriminant of the growth, a quadratic in s, vanishes."""
    ring, growth = _growth()
    s, d = ring["s"], ring["d"]
    c2, c1, c0 = (ring.coefficient(growth, s**k, [s]) for k in (2, 1, 0))
    discriminant = c1**2 - 4 * c2 * c0
    a, b, c = (ring.coefficient(discriminant, d**k, [d]).as_expr() for k in (2, 1, 0))
    return a, b, c


def _curvatures(a1: Expr) -> tuple[Expr, Expr]:
    """R^2 = a1 delta + a2 delta^2: order delta^2 of the amplitude equation divided by A, and of A_tip^2.

    (beta2 + alpha' a1 + alpha5 a1^2 + alpha a2) delta^2 has the real part 0 and the imaginary part of omega.
    """
    names = ("alpha", "alpha1", "alpha5", "beta2")
    ring = jet_ring(
        [f"{n}_{part}" for n in names for part in ("re", "im")] + ["a1", "a2", "third_re", "R", "d"]
    )
    alpha, alpha1, alpha5, beta2 = (ring[f"{n}_re"] + ring.i * ring[f"{n}_im"] for n in names)
    rate = beta2 + alpha1 * ring["a1"] + alpha5 * ring["a1"] ** 2 + alpha * ring["a2"]
    real = ring.real(rate)
    imaginary = (rate - real) / ring.ring.domain(0, 1)
    rest = ring.coefficient(real, ring.one, [ring["a2"]])
    a2 = -rest.as_expr() / ring.coefficient(real, ring["a2"], [ring["a2"]]).as_expr()
    # y(1) = 2 Re (A + Y300(1) A^3) is largest at phase 0 to this order: A_tip = 2 R + 2 Re Y300(1) R^3.
    tip = 2 * ring["R"] + 2 * ring["third_re"] * ring["R"] ** 3
    squared = tip**2
    by_r2 = ring.coefficient(squared, ring["R"] ** 2, [ring["R"]]).as_expr()
    by_r4 = ring.coefficient(squared, ring["R"] ** 4, [ring["R"]]).as_expr()
    letter = symbol("a1")
    amplitude = (by_r2 * a2 + by_r4 * letter**2).subs(letter, a1)
    frequency = imaginary.as_expr().subs(symbol("a2"), a2).subs(letter, a1)
    return amplitude, frequency
