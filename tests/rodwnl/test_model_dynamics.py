"""Orbits and runs of rods other than the plain one, on their emitted laws."""

from pathlib import Path

import numpy as np
import pytest

from rodwnl.emittedlaw import emitted_law
from rodwnl.laws import LAWS
from rodwnl.models import emitted
from rodwnl.nilpotent import exp, log, nilpotent
from rodwnl.normalform import _Discrete
from rodwnl.parameters import RodParameters

EXAMPLES = Path(__file__).resolve().parents[2] / "examples"
SOFT = (200.0, 1e4, 1e-4)


@pytest.mark.parametrize("model", LAWS)
def test_emitted_laws_are_those_written_by_hand(model):
    """R and its exact first derivatives by state and force at a strained state."""
    rod = RodParameters(*SOFT, model=model)
    by_hand = LAWS[model](*SOFT, **{name: float(value) for name, value in rod.own})
    one, other = (_Discrete(law, 12) for law in (emitted_law(rod), by_hand))
    w = 0.1 * np.random.default_rng(3).standard_normal(one.size)
    w[-3] += 0.8
    pull = np.zeros_like(w), 1.0
    for found, expected in (
        (one.derivative(w, 30.0), other.derivative(w, 30.0)),
        (one.derivative(w, 30.0, pull), other.derivative(w, 30.0, pull)),
        (one.jacobian(w, 30.0), other.jacobian(w, 30.0)),
    ):
        np.testing.assert_allclose(found, expected, rtol=1e-12, atol=1e-12 * np.abs(expected).max())


def test_exponentials_and_logarithms_are_differentiated():
    """log(exp(f)) is f through the third derivative, and exp is its own."""
    x = nilpotent(0.7, (1, 1.0), (2, 2.0), (3, 3.0))
    same = log(exp(x * x))
    for directions in ((), (1,), (1, 2), (1, 2, 3)):
        assert same.part(*directions) == pytest.approx((x * x).part(*directions), abs=1e-13)
        assert exp(nilpotent(0.7, (1, 1.0), (2, 1.0), (3, 1.0))).part(*directions) == pytest.approx(np.exp(0.7))
