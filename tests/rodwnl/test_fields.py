"""Sums of exponentials: the algebra against plain evaluation, the boundary-value problem against itself."""

import mpmath as mp
import pytest

from rodwnl.fields import Exponents, Field, MpArithmetic, two_point

POINTS = [mp.mpf(n) / 7 for n in range(8)]


@pytest.fixture(autouse=True)
def _forty_digits():
    with mp.workdps(40):
        yield


def close(a, b, digits=34):
    return abs(a - b) <= mp.mpf(10) ** -digits * max(1, abs(a), abs(b))


def basis(*generators):
    return Exponents([mp.mpmathify(g) for g in generators], MpArithmetic())


def sample(exponents, seed=1):
    """A field with many different terms, polynomial factors included."""
    size, terms = len(exponents.basis), {exponents.zero: (mp.mpf(seed) / 3, mp.mpc(1, -seed))}
    for i in range(size):
        key = tuple((i + 1) * (j == i) - (j == (i + seed) % size) for j in range(size))
        terms[key] = tuple(mp.mpc(seed + i, k - 2) / 5 for k in range(1 + (i + seed) % 3))
    return exponents.field(terms)


GENERATORS = (mp.mpc(1, "0.7"), mp.mpc("-0.4", 2))


def test_algebra_is_that_of_functions():
    e = basis(*GENERATORS)
    f, g, u = sample(e), sample(e, 2), e.u(mp.mpf(1))
    for x in POINTS:
        fx, gx = f(x), g(x)
        assert close((f * g)(x), fx * gx)
        assert close((2 * f - g / 3 + 1j)(x), 2 * fx - gx / 3 + 1j)
        assert close((1 - f)(x), 1 - fx)
        assert close((f**3)(x), fx**3)
        assert close(f.conjugate()(x), mp.conj(fx))
        assert close((u * f)(x), x * fx)
        assert close(f.derivative()(x), mp.diff(f, x), 20)
        assert close(f.antiderivative()(x), mp.quad(f, [0, x]), 30)
    assert close(f.at_start(), f(0))
    assert close(f.at_tip(), f(1))
    assert close(f.integral(), mp.quad(f, [0, 1]))
    assert close(f.integral(), f.antiderivative().at_tip())


def test_equal_exponents_merge():
    e = basis(*GENERATORS)
    f = e.field({e.key(0): (mp.mpf(1),), e.key(0, -1): (mp.mpf(1),)})
    assert len((f * f).terms) == 3
    assert len((f * f.conjugate()).terms) == 4
    assert set((e.field({e.key(1): (mp.mpf(2),)}) * e.field({e.key(1, -1): (mp.mpf(3),)})).terms) == {e.zero}


@pytest.mark.parametrize("p", [0, 1, 2, 5])
@pytest.mark.parametrize(
    "a", ["0", "1e-30", "1e-9", "-0.3", "0.999", "1", "2.01", "-5.99", "6.01", "-40", "300"]
)
def test_moments_at_every_size_of_the_exponent(p, a):
    a = mp.mpf(a) * mp.expj(mp.mpf(p))
    value = MpArithmetic().moment(p, a)
    with mp.workdps(80):
        expected = mp.hyp1f1(p + 1, p + 2, a) / (p + 1)
    assert abs(value - expected) < mp.mpf(10) ** -33 * abs(expected)


def assert_solves(X, forcing, s, slope):
    defect = X.derivative().derivative() - s * s * X - forcing
    assert all(close(defect(x), 0) for x in POINTS)
    assert close(X.at_start(), 0)
    assert close(X.derivative().at_tip(), slope)


@pytest.mark.parametrize(
    ("generators", "root"),
    [
        (GENERATORS, (0, 0, 1, 0)),  # nothing coincides
        (GENERATORS, (0, 0, 0, 0)),  # s = 0, and a constant in the forcing
        ((mp.mpc(1, "0.7"), mp.mpc(2, "1.4")), (0, 0, 1, 0)),  # 2 g1 = s, by value and not by name
        ((mp.mpc(1, "0.7"), mp.mpc(-2, "-1.4")), (0, 0, 1, 0)),  # 2 g1 = −s
        ((mp.mpf(1) / 3, mp.mpc(0, 1)), (0, 0, 0, 0)),  # g1 − g1* = 0: a real exponent in a mean
        ((mp.mpc(0, 2), mp.mpc(0, 1)), (0, 0, 1, 0)),  # imaginary exponents: −g1* = g1, g2 + g2* = 0
    ],
)
def test_two_point_problem_generic_and_resonant(generators, root):
    e = basis(*generators)
    s, slope = e.value(root), mp.mpc(3, -1)
    own = e.field({root: (mp.mpf(2), mp.mpf(-1), mp.mpf(4)), tuple(-n for n in root): (mp.mpc(0, 1),)})
    difference = e.field({(1, -1, 0, 0): (mp.mpf(1), mp.mpf(5)), (2, 0, 0, 0): (mp.mpf(7), mp.mpf(1))})
    for forcing in (sample(e), own, difference):
        assert_solves(two_point(forcing, root, slope), forcing, s, slope)


def near_resonance(gap):
    """X'' − s²X = e^{gu} with g = s + gap, X(0) = 0, X'(1) = 1."""
    s = mp.mpc(2, 3)
    e = basis(s + gap, s)
    return two_point(e.field({e.key(0): (mp.mpf(1),)}), e.key(1), mp.mpf(1))


def test_both_sides_of_a_resonance_tend_to_what_holds_on_it():
    on = near_resonance(mp.mpf(0))
    assert any(len(p) == 2 for p in on.terms.values())
    for gap in (mp.mpf("1e-6"), mp.mpc(0, "1e-8")):
        above, below = near_resonance(gap), near_resonance(-gap)
        for x in POINTS[1:]:
            slope = abs(above(x) - below(x)) / (2 * abs(gap))
            assert 0 < abs(above(x) - on(x)) < 2 * slope * abs(gap)
            assert abs((above(x) + below(x)) / 2 - on(x)) < 10 * abs(gap) ** 2


def test_gap_below_the_working_precision_counts_as_none():
    on, near = near_resonance(mp.mpf(0)), near_resonance(mp.mpf("1e-39"))
    assert all(close(near(x), on(x)) for x in POINTS)


def test_what_is_not_closed_is_refused():
    e = basis(*GENERATORS)
    f = sample(e)
    with pytest.raises(TypeError, match="divided by a number"):
        f / f
    with pytest.raises(TypeError, match="positive integer powers only, not 0"):
        f**0.5
    with pytest.raises(TypeError, match="not 0"):
        f**0
    with pytest.raises(ValueError, match="do not share"):
        f + sample(basis(*GENERATORS))
    assert isinstance(f, Field)
