"""The normal form to any order: it contains the theory of order 3 and obeys the symmetries of the rod."""

import pytest

from derivation.anyorder import expand_normal_form, indices
from derivation.jets import homomorphism
from derivation.pipeline import derive
from derivation.solvability import canonical


@pytest.fixture(scope="module")
def quintic():
    return derive(order=5)


def response(d, index):
    return next(r for r in d.normal_form.responses if r.index == index)


def in_modes(d, p):
    """An element of the normal form's ring in the letters of the theory at order 3."""
    ring, modes = d.normal_form.ring, d.second.modes
    target = modes.ring
    static = modes.fields["x", 2].diff(target["Delta"])
    images = {}
    for suffix in ("", "_u", "_uu"):
        real_mean = target[f"X0{suffix}"] + target[f"X0_bar{suffix}"]
        images |= {
            ring[f"X200{suffix}"]: target[f"X2{suffix}"],
            ring[f"X200_bar{suffix}"]: target[f"X2_bar{suffix}"],
            ring[f"X110{suffix}"]: real_mean,
            ring[f"X001{suffix}"]: static,
        }
        static = target.derive(static, "u")
    return homomorphism(p, images, target)


@pytest.mark.parametrize(("index", "part"), [((2, 1, 0), "cubic"), ((1, 0, 1), "detuning")])
def test_order_three_is_contained(quintic, index, part):
    """The responses to A^2 A* and delta A are forced as the resonant terms of order 3 are."""
    d, r = quintic, response(quintic, index)
    for ours, theirs in zip(r.forcing, getattr(d.third.bulk, part), strict=True):
        difference = d.second.modes.reduce(in_modes(d, ours)) - theirs
        assert canonical(d.hierarchy, d.second.modes.ring, difference) == d.second.modes.ring.zero
    for ours, theirs in zip(r.traction, getattr(d.third.traction, part), strict=True):
        mapped = in_modes(d, ours)
        for c in (d.second.mean, d.second.harmonic):
            ring = d.second.modes.ring
            slope = ring[f"X{c.harmonic}_u"]
            rules = {slope: c.tip_slope, ring.conjugate(slope): ring.conjugate(c.tip_slope)}
            mapped = ring.apply(mapped, rules)
        difference = d.second.modes.at_tip(mapped) - theirs
        assert canonical(d.hierarchy, d.second.modes.ring, difference) == d.second.modes.ring.zero


def test_second_harmonic_and_mean_are_those_of_order_two(quintic):
    d, ring = quintic, quintic.second.modes.ring
    for index, c in (((2, 0, 0), d.second.harmonic), ((1, 1, 0), d.second.mean)):
        (ours,) = response(d, index).forcing
        theirs = -(c.forcing if c.harmonic else c.forcing + ring.conjugate(c.forcing))
        if c.harmonic:
            theirs = ring.apply(theirs, {})
        difference = d.modes.reduce(in_modes(d, ours)) - d.modes.reduce(theirs)
        assert canonical(d.hierarchy, ring, difference) == ring.zero


def test_forcings_are_equivariant_under_a_phase_of_the_amplitude(quintic):
    """A -> A e^{i phi}, Phi_pqr -> Phi_pqr e^{-i (p - q) phi} leaves every problem as it is."""
    ring = quintic.normal_form.ring

    def charge(name):
        digits = "".join(c for c in name.split("_")[0] if c.isdigit())
        if name[0] not in "XYTc" or not (digits or name.split("_")[0] in ("Y", "Theta")):
            return 0
        p, q, _ = map(int, digits or "100")
        sign = -1 if "_bar" in name else 1
        return sign * (p - q - (name[0] == "c"))

    for r in quintic.normal_form.responses:
        for row in (*r.forcing, *r.traction):
            for monom in row.monoms():
                total = sum(e * charge(s.name) for s, e in zip(ring.ring.symbols, monom, strict=True))
                assert total == r.index[0] - r.index[1]


def test_reflection_symmetry_separates_even_from_odd(quintic):
    """Terms of even degree in (A, A*) move x only, of odd degree y and theta only."""
    for r in quintic.normal_form.responses:
        assert r.fields == (("x",) if sum(r.index[:2]) % 2 == 0 else ("y", "theta"))


def test_a_lower_order_is_a_part_of_a_higher_one(quintic):
    cubic = derive(order=3).normal_form
    for r in cubic.responses:
        higher = next(s for s in quintic.normal_form.responses if s.index == r.index)
        assert [f.as_expr() for f in r.forcing] == [f.as_expr() for f in higher.forcing]
        assert [t.as_expr() for t in r.traction] == [t.as_expr() for t in higher.traction]


def test_indices_count_the_terms():
    assert [i for i in indices(3) if i[0] == i[1] + 1] == [(1, 0, 0), (1, 0, 1), (2, 1, 0)]
    assert len([i for i in indices(5) if i[0] == i[1] + 1]) == 6


@pytest.mark.parametrize("order", [1, 2, 4])
def test_orders_without_a_new_term_are_refused(quintic, order):
    with pytest.raises(
        ValueError, match=f"order = {order}: the amplitude equation gains terms at odd orders"
    ):
        expand_normal_form(quintic.exact, quintic.law, order)
