import math
from decimal import Decimal
from fractions import Fraction

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from rodwnl.errors import InputError
from rodwnl.parameters import RodParameters, decimal_text, exact

positives = st.floats(1e-12, 1e12)


@pytest.mark.parametrize(
    "value", ["2e-4", " 2e-4 ", "1/5000", 2e-4, np.float64(2e-4), Fraction(1, 5000), Decimal("0.0002")]
)
def test_every_number_type_is_read_exactly(value):
    assert RodParameters(200, 10**4, value).gamma3 == Fraction(1, 5000)


def test_axial_drag_defaults_to_one_half():
    assert RodParameters(200, "1e4", 1).gamma1 == Fraction(1, 2)


def test_floats_are_in_the_order_of_the_fields():
    assert RodParameters("1", "2", "3", "4").floats() == (1.0, 2.0, 3.0, 4.0)


@pytest.mark.parametrize("name", ["k1", "k2", "gamma3", "gamma1"])
@pytest.mark.parametrize(
    ("value", "message"),
    [
        ("0", "greater than zero"),
        (-1, "greater than zero"),
        ("nan", "not a finite number"),
        (math.inf, "not a finite number"),
        ("two", "not a finite number"),
        ("", "not a finite number"),
        ("1/0", "not a finite number"),
        ("1e", "not a finite number"),
        ("__import__('os')", "not a finite number"),
        ("1e999999999", "between 1e-300 and 1e300"),
        ("1e-301", "between 1e-300 and 1e300"),
        ("1" * 2000, "it has 2000 characters, more than 1000"),
        (True, "must be a number"),
        (1j, "must be a number"),
        (None, "must be a number"),
    ],
)
def test_bad_values_are_refused_by_name(name, value, message):
    values = {"k1": 1, "k2": 1, "gamma3": 1, "gamma1": 1} | {name: value}
    with pytest.raises(InputError, match=rf"^{name} .*{message}") as error:
        RodParameters(**values)
    assert len(str(error.value)) < 150


def test_a_force_lies_between_zero_and_k1():
    rod = RodParameters(200, 1, 1)
    assert rod.checked_force(0) == 0
    assert rod.checked_force("199.5") == Fraction(399, 2)
    with pytest.raises(InputError, match=r"force is 200\.0000001, but"):  # as given, not as a quotient
        rod.checked_force(Fraction("200.0000001"))
    for bad in (-1, 200, "1e3"):
        with pytest.raises(InputError, match="0 <= force < k1 = 200"):
            rod.checked_force(bad)


@pytest.mark.parametrize(
    ("number", "text"),
    [
        (Fraction(10**4), "10000"),
        (Fraction(1, 5000), "0.0002"),
        (Fraction(-3, 8), "-0.375"),
        (Fraction(1, 3), "1/3"),
        (Fraction(10) ** 300, "1E+300"),
        (Fraction(0), "0"),
    ],
)
def test_decimal_text(number, text):
    assert decimal_text(number) == text


@given(st.fractions(max_denominator=10**9))
def test_decimal_text_can_be_read_back(number):
    if number:
        assert exact("number", decimal_text(number)) == number


@given(positives)
def test_a_float_is_read_as_the_decimal_it_prints_as(value):
    assert float(exact("value", value)) == value
    assert exact("value", value) == exact("value", repr(value))


@given(*[positives] * 7)
def test_physical_scales_undo_the_scaling(L, k1, k2, k3, g1, g2, g3):
    rod = RodParameters.from_physical(L, k1, k2, k3, g1, g2, g3)
    length, time, force = rod.scales.length, rod.scales.time, rod.scales.force
    assert length == exact("L", L)
    assert force * rod.k1 == exact("k1", k1)
    assert force * rod.k2 == exact("k2", k2)
    assert force * length**2 == exact("k3", k3)
    # drags: force per length and speed; torque per length and angular speed
    assert rod.gamma1 * force * time / length**2 == exact("gamma1", g1)
    assert force * time / length**2 == exact("gamma2", g2)
    assert rod.gamma3 * force * time == exact("gamma3", g3)


def test_physical_values_are_checked_by_name():
    with pytest.raises(InputError, match=r"^L is 0"):
        RodParameters.from_physical(0, 1, 1, 1, 1, 1, 1)


def test_a_rod_is_a_value():
    assert RodParameters(200, 1e4, "1e-4") == RodParameters("2e2", "10000", "1/10000")
    assert len({RodParameters(200, 1e4, "1e-4"), RodParameters("2e2", "10000", "1/10000")}) == 1
    with pytest.raises(AttributeError):
        RodParameters(1, 1, 1).k1 = 2
    assert repr(RodParameters(200, "1e4", "1/3")) == "RodParameters(k1=200, k2=10000, gamma3=1/3, gamma1=0.5)"
