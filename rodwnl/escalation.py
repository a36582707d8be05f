"""Where double precision keeps too few digits: the coefficients from the exact route, rounded to doubles."""

from __future__ import annotations

from dataclasses import replace

from rodwnl.coefficients import LandauCoefficients
from rodwnl.exact import exact_threshold
from rodwnl.parameters import RodParameters
from rodwnl.spectrum import EPS, HopfThreshold

DIGITS = 17  # so that rounding to a double is all that is lost


def exact_coefficients(rod: RodParameters, threshold: HopfThreshold) -> LandauCoefficients:
    """The coefficients at a threshold known to a few digits. Every error is one rounding.

    Raises ComputationError where the exact route finds no threshold there or cannot reach its digits.
    """
    e = exact_threshold(rod, threshold.force, threshold.omega, DIGITS)
    force, omega, alpha, beta = float(e.force), float(e.omega), complex(e.alpha), complex(e.beta)
    residuals = {name: float(r) for name, r in e.residuals.items()}
    exact = replace(
        threshold, force=force, omega=omega, slope=beta, residual=residuals["mode"],
        force_error=EPS * force, omega_error=EPS * omega,
    )  # fmt: skip
    A_tip2_slope, omega_slope = float(e.A_tip2_slope), float(e.omega_slope)
    return LandauCoefficients(
        exact, alpha, beta,
        alpha_parts=(complex(e.alpha_parts[0]), complex(e.alpha_parts[1])),
        beta_parts=(complex(e.beta_parts[0]), complex(e.beta_parts[1])),
        A_tip2_slope=A_tip2_slope, omega_slope=omega_slope,
        alpha_error=EPS * abs(alpha), beta_error=EPS * abs(beta),
        A_tip2_slope_error=EPS * abs(A_tip2_slope), omega_slope_error=EPS * abs(omega_slope),
        residuals=residuals, working_digits=e.working_digits,
    )  # fmt: skip
