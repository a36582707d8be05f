"""Exact directional derivatives by nilpotent numbers."""

import numpy as np
import pytest

from rodwnl.nilpotent import Nilpotent, cos, nilpotent, sin

A, B, C, D = 0.7, 1.3, -0.4 + 0.2j, 2.1


def three(f):
    """f(A + e1 B + e2 C + e3 D)."""
    return f(nilpotent(A, (1, B), (2, C), (3, D)))


@pytest.mark.parametrize(
    ("f", "derivatives"),
    [
        (lambda a: a * a * a, (A**3, 3 * A**2, 6 * A, 6)),
        (lambda a: 2 - a**4 + a, (2 - A**4 + A, 1 - 4 * A**3, -12 * A**2, -24 * A)),
        (lambda a: 1 / a, (1 / A, -1 / A**2, 2 / A**3, -6 / A**4)),
        (lambda a: (a + 1) / a, (1 + 1 / A, -1 / A**2, 2 / A**3, -6 / A**4)),
        (lambda a: (a * a) ** 0.5, (A, 1, 0, 0)),
        (sin, (np.sin(A), np.cos(A), -np.sin(A), -np.cos(A))),
        (cos, (np.cos(A), -np.sin(A), -np.cos(A), np.sin(A))),
        (lambda a: sin(a) ** 2 + cos(a) * cos(a), (1, 0, 0, 0)),
    ],
)
def test_parts_are_the_directional_derivatives(f, derivatives):
    out = three(f)
    d0, d1, d2, d3 = derivatives
    close = {"rel": 1e-13, "abs": 1e-14}
    assert out.part() == pytest.approx(d0, **close)
    assert out.part(1) == pytest.approx(d1 * B, **close)
    assert out.part(3) == pytest.approx(d1 * D, **close)
    assert out.part(1, 2) == pytest.approx(d2 * B * C, **close)
    assert out.part(1, 2, 3) == pytest.approx(d3 * B * C * D, **close)


def test_arrays_and_linear_maps_go_through():
    a, b = np.arange(3.0), np.ones(3)
    out = (a * nilpotent(a, (1, b))).map(np.sum)
    assert out.part() == 5
    assert out.part(1) == 3
    assert isinstance(a * nilpotent(a), Nilpotent)


def test_a_number_without_directions_is_a_number():
    assert nilpotent(2.0).part(1) == 0
    assert sin(0.0) == 0
    assert cos(0.0) == 1
