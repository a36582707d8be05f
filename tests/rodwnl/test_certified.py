"""Certified thresholds: the characteristic function, the bound and the count behind them; refusals."""

import sys

import mpmath as mp
import numpy as np
import pytest

from rodwnl.balls import BallNumbers, enclosure, relative_accuracy, square_root, working_bits
from rodwnl.certified import certify_threshold
from rodwnl.errors import ComputationError, InputError
from rodwnl.exact import exact_threshold
from rodwnl.halfplane import Value, _turn, characteristic, count_right_of, unstable_region
from rodwnl.isolation import DecimalBox, steady_box, steady_enclosure, tight_box, uniqueness_box
from rodwnl.linearrod import linear_rod
from rodwnl.parameters import RodParameters
from rodwnl.spectrum import hopf_thresholds, leading_eigenvalues
from rodwnl.steady import steady_force

from .theorems import assert_emitted_determinant, assert_energy_identity

flint = pytest.importorskip("flint", reason="python-flint, the extra `certified`, is not installed")

RODS = [
    ("1e4", "1e4", "1e-4"),
    ("1e4", "1e2", "1e-2"),  # k2 gamma3 = 1 exactly
    ("200", "1e4", "1e-4"),
    ("30", "5", "1e-3"),
    ("1e8", "1e8", "1"),
]


@pytest.fixture(autouse=True)
def _bits():
    with working_bits(128):
        yield


def ball_rod(parameters, force):
    return linear_rod(RodParameters(*parameters), flint.arb(force))


@pytest.mark.parametrize("parameters", RODS)
def test_characteristic_function_is_the_emitted_determinant_over_the_wronskian(parameters):
    assert_emitted_determinant(RodParameters(*parameters), 11)


def test_characteristic_function_is_smooth_where_an_exponent_vanishes():
    rod = ball_rod(RODS[0], 30)
    at_0, near_0 = characteristic(rod, flint.acb(0)).whole, characteristic(rod, flint.acb("1e-20")).whole
    assert at_0.is_finite()
    assert abs(at_0 - near_0).abs_upper() < 1e-12 * abs(near_0)


def test_energy_identity_behind_the_bound():
    assert_energy_identity(RodParameters(200, "1e4", "1e-4"), "155.6", "3367.28")


@pytest.mark.parametrize("parameters", RODS)
def test_every_eigenvalue_in_sight_obeys_the_bound(parameters):
    floats = (*(float(p) for p in parameters), 0.5)
    for force in (1.0, 12.0, 25.0):
        margin = 50.0
        region = unstable_region(ball_rod(parameters, force), flint.arb(margin))
        eigenvalues = leading_eigenvalues(floats, np.array([force]))[0].ravel()
        for lam in eigenvalues[eigenvalues.real > -margin]:
            assert lam.real < float(region.right)
            assert abs(lam.imag) < float(region.top)


@pytest.mark.parametrize(
    ("parameters", "forces"),
    [
        (RODS[0], {10: 0, 37.6559: 0, 37.6560: 2, 200: 4, 1500: 10}),
        (RODS[1], {10: 0, 100: 4, 300: 10}),
        (RODS[2], {49.7: 0, 49.8: 2, 155.5: 2, 155.7: 0}),
        (RODS[4], {22: 0, 22.2: 2}),
    ],
)
def test_counts_of_unstable_eigenvalues(parameters, forces):
    # the numbers for large forces: from the float64 spectrum on 160 nodes
    for force, expected in forces.items():
        rod = ball_rod(parameters, force)
        line = flint.arb("1e-6")
        assert count_right_of(rod, line, unstable_region(rod, line)) == expected


def test_a_line_through_an_eigenvalue_proves_nothing():
    rod = ball_rod(RODS[0], "37.65598054527106685188989170163149 +/- 1e-30")
    with pytest.raises(ComputationError, match=r"on the contour or close to it, near .*191\.2"):
        count_right_of(rod, flint.arb(0), unstable_region(rod, flint.arb(1)))


THRESHOLDS = [
    (RODS[0], 37.66, 191.21, "destabilizing", "supercritical"),
    (RODS[1], 27.43, 113.55, "destabilizing", "supercritical"),
    (RODS[2], 49.76, 334.32, "destabilizing", "supercritical"),
    (RODS[2], 155.60, 3367.28, "restabilizing", "subcritical"),
]


@pytest.mark.parametrize(("parameters", "force", "omega", "crossing", "criticality"), THRESHOLDS)
def test_the_papers_thresholds_are_theorems(parameters, force, omega, crossing, criticality):
    rod = RodParameters(*parameters)
    c = certify_threshold(rod, force, omega, 30)
    assert (c.crossing, c.criticality, c.unstable) == (crossing, criticality, 0)
    assert len(c.proved) == 5
    with mp.workdps(60):
        e = exact_threshold(rod, force, omega, 50)
        pairs = [(c.force, e.force), (c.omega, e.omega), (c.A_tip2_slope, e.A_tip2_slope)]
        pairs += [(c.omega_slope, e.omega_slope), (c.alpha[0], e.alpha.real), (c.alpha[1], e.alpha.imag)]
        pairs += [(c.beta[0], e.beta.real), (c.beta[1], e.beta.imag)]
        for ball, number in pairs:
            assert ball.overlaps(flint.arb(mp.nstr(number, 52)))
            assert relative_accuracy(ball) >= 30
            mid, rad = (mp.mpf(text) for text in enclosure(ball, 30).values())
            assert abs(mid - number) <= rad < mp.mpf(10) ** -29 * abs(mid)
    assert c.unique_in.balls.force.contains(c.force)
    assert c.unique_in.balls.omega.contains(c.omega)


def test_a_later_crossing_is_not_leading():
    # the second pair of the stiff rod crosses after the first one
    rod = RodParameters(*RODS[0])
    c = certify_threshold(rod, *second_crossing(rod), 15)
    assert c.unstable == 2
    assert any("2 eigenvalues have Re lambda >= 0" in s and "not leading" in s for s in c.proved)


def second_crossing(rod):
    """From the float64 spectrum: bisection of the second largest growth rate."""
    low, high = 150.0, 200.0
    for _ in range(40):
        middle = (low + high) / 2
        eigenvalues = leading_eigenvalues(rod.floats(), np.array([middle]))[0].ravel()
        second = sorted((z for z in eigenvalues if z.imag > 0), key=lambda z: -z.real)[1]
        low, high = (low, middle) if second.real > 0 else (middle, high)
    return middle, second.imag


def test_stiff_rods_are_certified_at_higher_precision():
    c = certify_threshold(RodParameters("1e30", "1e30", "1e-30"), 37.695430840318579, 191.258635765253, 20)
    assert relative_accuracy(c.alpha[0]) >= 20
    assert c.force.overlaps(flint.arb("37.695430840318577884 +/- 1e-18"))


def test_no_threshold_no_theorem():
    with pytest.raises(
        ComputationError, match=r"not proved: existence and uniqueness .*no threshold is there"
    ):
        certify_threshold(RodParameters(*RODS[0]), 20.0, 191.0)


@pytest.mark.parametrize("digits", [0, 10**7, 1.5])
def test_digits_out_of_range_are_refused(digits):
    with pytest.raises(InputError, match="whole number from 1 to 10000"):
        certify_threshold(RodParameters(*RODS[0]), 37.66, 191.21, digits)


def test_without_python_flint_it_says_what_to_install(monkeypatch):
    monkeypatch.setitem(sys.modules, "flint", None)
    with pytest.raises(InputError, match=r"pip install 'rodwnl\[certified\]'"):
        certify_threshold(RodParameters(*RODS[0]), 37.66, 191.21)


def test_balls_of_moments_and_roots_contain_the_truth():
    numbers = BallNumbers()
    for p in (0, 1, 4):
        for a in (0, 1e-30, -0.5 + 1j, 4.9, 30j):
            with mp.workdps(50):
                expected = mp.hyp1f1(p + 1, p + 2, mp.mpmathify(a)) / (p + 1)
            ball = numbers.moment(p, flint.acb(a))
            assert ball.overlaps(flint.acb(mp.nstr(expected.real, 45), mp.nstr(expected.imag, 45)))
            assert ball.rel_accuracy_bits() > 90
    for z in (-4 + 1e-30j, -4 - 1e-30j, 2 + 0j):
        root = square_root(flint.acb(z))
        assert (root * root).overlaps(flint.acb(z))
        wide = square_root(flint.acb(flint.arb(z.real, 0.1), flint.arb(z.imag, 0.1)))
        assert float(abs(wide).rad()) < 0.1


def test_overlapping_exponents_are_refused():
    with pytest.raises(ComputationError, match="too close to tell"):
        BallNumbers().coincide(flint.acb("1 +/- 1e-10"), flint.acb(1))
    assert not BallNumbers().coincide(flint.acb("1 +/- 1e-10"), flint.acb(2))


def test_decimal_enclosures_mean_what_they_say():
    third = flint.arb(flint.fmpq(1, 3))
    texts = enclosure(third, 10)
    assert flint.arb(f"{texts['mid']} +/- {texts['rad']}").contains(flint.fmpq(1, 3))
    assert texts["mid"].startswith("0.33333")
    assert enclosure(flint.arb("0.5"), 10) == {"mid": "0.5000000000", "rad": "0"}


def just_short_of(force: mp.mpf, near: float) -> tuple[str, str]:
    """An interval that ends 1e-11 of its radius before the force: its ball, with 30 bits of it, has it."""
    with mp.workdps(40):
        middle = f"{near:.6f}"
        return middle, mp.nstr(abs(mp.mpf(force) - mp.mpf(middle)) * (1 - mp.mpf("1e-11")), 25)


def test_the_threshold_lies_in_the_printed_box_and_not_only_in_its_ball():
    rod = RodParameters("1e4", "1e4", "1e-4")
    t = hopf_thresholds(rod)[0]
    e = exact_threshold(rod, t.force, t.omega, 35)
    box = tight_box(rod, t.force, t.omega, 30, uniqueness_box(rod, t.force, t.omega))
    printed = DecimalBox(just_short_of(e.force, t.force), (f"{t.omega:.12g}", "0.1"))
    assert printed.balls.force.contains(box.force)
    with pytest.raises(ComputationError, match="outside the box"):
        tight_box(rod, t.force, t.omega, 30, printed)


def test_a_steady_crossing_lies_in_the_printed_interval_too():
    rod = RodParameters("1e4", "1e2", "1e-2", model="partial_follower", chi="0.3")
    near = hopf_thresholds(rod, 5).steady[0].force
    printed = DecimalBox(just_short_of(steady_force(rod, near, 40), near), ("0", "0"))
    assert printed.balls.force.contains(steady_enclosure(rod, near, 25, steady_box(rod, near)))
    with pytest.raises(ComputationError, match="not proved: an enclosure"):
        steady_enclosure(rod, near, 25, printed)


def test_the_growth_turns_exactly_only_where_all_of_it_is_of_one_branch():
    one = flint.acb(1)
    piece, start = Value(one, flint.acb(1, flint.arb(0, 4)), True), Value(one, flint.acb(0, -3), False)
    end = Value(one, flint.acb(0, "3.1"), True)
    assert _turn(piece, start, end) is None
    piece = Value(one, flint.acb(0, flint.arb(3, "0.2")), True)
    assert abs(_turn(piece, start, end) - (flint.arb("6.1") - 2 * flint.arb.pi())) < 1e-20
    assert abs(_turn(piece, Value(one, flint.acb(0, 3), True), end) - flint.arb("0.1")) < 1e-20


def test_a_ball_that_contains_0_has_the_middle_0():
    assert enclosure(flint.arb(0, 1e-10), 10)["mid"] == "0"
    assert float(enclosure(flint.arb(1e-12, 1e-10), 10)["rad"]) >= 1.01e-10
    assert enclosure(flint.arb(2), 10) == {"mid": "2.000000000", "rad": "0"}
