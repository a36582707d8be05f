"""The amplitude equation at order 5: against the other route at order 3, in another gauge, against orbits."""

import math

import numpy as np
import pytest

from rodwnl import InputError, RodParameters, landau
from rodwnl.models import emitted
from rodwnl.modes import nodes_at
from rodwnl.quadrature import gauss_legendre
from rodwnl.responses import _responses, amplitude_equation, terms

RODS = [("1e4", "1e4", "1e-4"), ("1e4", "1e2", "1e-2"), ("200", "1e4", "1e-4"), ("731", "57", "3e-3", "1.1")]


@pytest.mark.parametrize("parameters", RODS, ids=str)
def test_alpha_and_beta_come_out_without_an_adjoint(parameters):
    rod = RodParameters(*parameters)
    for threshold in landau(rod):
        equation = amplitude_equation(rod, threshold.threshold)
        assert equation.coefficients["c210"] == pytest.approx(threshold.alpha, rel=1e-9)
        assert equation.coefficients["c101"] == pytest.approx(threshold.beta, rel=1e-9)
        assert equation.A_tip2_slope == pytest.approx(threshold.A_tip2_slope, rel=1e-9)
        assert equation.omega_slope == pytest.approx(threshold.omega_slope, rel=1e-9)


def test_change_of_gauge():
    """A -> A (1 + g |A|^2): alpha stays; alpha' loses 2 g Re beta, alpha5 gains 2 i Im(alpha g*)."""
    rod, g = RodParameters("1e4", "1e4", "1e-4"), 0.7 - 1.3j
    (threshold,) = landau(rod)
    force, omega = threshold.force, threshold.omega
    nodes = gauss_legendre(len(nodes_at(rod.floats(), force, omega).u) + 16)
    c, moved = (
        _responses(rod, force, omega, nodes).solve(5, gauge).coefficients for gauge in ({}, {(2, 1, 0): g})
    )
    alpha, beta = c["c210"], c["c101"]
    for name in ("c210", "c101", "c102"):
        assert moved[name] == pytest.approx(c[name], rel=1e-10)
    assert moved["c211"] - c["c211"] == pytest.approx(-2 * g * beta.real, rel=1e-8)
    assert moved["c320"] - c["c320"] == pytest.approx(2j * (alpha * np.conj(g)).imag, rel=1e-6)


METRIC = """
name = "loaded_metric"
energy = "k1*(exp(h1 - 1) - h1) + k2*h2^2/2 + Pi^2/2"
[drag]
v1 = "gamma1*sqrt(h1^2 + h2^2)"
v2 = "sqrt(h1^2 + h2^2)"
Omega = "gamma3"
[[load]]
kind = "distributed"
"""


@pytest.mark.parametrize("model", ["follower", METRIC], ids=["follower", "loaded_metric"])
def test_curvatures_are_those_of_the_branch_of_orbits(model, tmp_path):
    """(A_tip^2/delta - slope)/delta at two small delta, extrapolated to onset; omega likewise."""
    from rodwnl.coexistence import periodic_orbits

    if model == METRIC:
        file = tmp_path / "rod.toml"
        file.write_text(METRIC)
        model = emitted(str(file))
    rod = RodParameters("200" if model != "follower" else "1e4", "1e2", "1e-2", model=model)
    (threshold,) = landau(rod)
    equation = amplitude_equation(rod, threshold.threshold)
    measured = []
    for delta in (0.02, 0.04):
        force = threshold.force + delta
        orbit = periodic_orbits(rod, force).orbits[0]
        delta = orbit.force - threshold.force
        measured.append(
            (
                (orbit.A_tip**2 / delta - equation.A_tip2_slope) / delta,
                ((orbit.omega - threshold.omega) / delta - equation.omega_slope) / delta,
            )
        )
    amplitude, frequency = (2 * a - b for a, b in zip(*measured, strict=True))
    assert amplitude == pytest.approx(equation.A_tip2_curvature, rel=1e-4)
    assert frequency == pytest.approx(equation.omega_curvature, rel=1e-2)


def test_order_three_has_no_curvature():
    rod = RodParameters("1e4", "1e4", "1e-4")
    (threshold,) = landau(rod)
    equation = amplitude_equation(rod, threshold.threshold, order=3)
    assert equation.A_tip2_curvature is equation.third_harmonic is None
    assert set(equation.coefficients) == {"c101", "c210"}
    with pytest.raises(InputError, match="orders 3 and 5"):
        amplitude_equation(rod, threshold.threshold, order=4)


def test_terms_are_those_that_are_emitted():
    from rodwnl import kernels

    for p, q, r in terms(5):
        name = ("Y" if (p + q) % 2 else "X") + f"{p}{q}{r}"
        assert callable(getattr(kernels, f"{name}_forcing"))
        assert callable(getattr(kernels, f"{name}_traction"))


def test_errors_bound_the_difference_between_two_grids():
    rod = RodParameters("1e5", "1e5", "1e-5")
    for threshold in landau(rod):
        equation = amplitude_equation(rod, threshold.threshold)
        assert all(error <= 1e-6 * abs(equation.coefficients[n]) for n, error in equation.errors.items())
        assert math.isfinite(equation.A_tip2_curvature)
