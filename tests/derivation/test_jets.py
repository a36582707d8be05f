"""The algebra: derivations, conjugation, rewriting, coefficients."""

import pytest
from sympy import I, Rational, sqrt

from derivation.jets import from_expr, homomorphism, jet_ring
from derivation.symbols import symbol


@pytest.fixture
def ring():
    return jet_ring(
        ["f", "f_u", "g", "k1", "k1_inv"],
        {"u": {"f": "f_u", "f_u": None}},
        {"f": "g"},
        {"k1": "k1_inv"},
    )


def test_derivation_obeys_leibniz(ring):
    f, g, k = ring["f"], ring["g"], ring["k1"]
    p, q = f**2 + k * f, 3 * f - g
    product = ring.derive(p * q, "u")
    assert product == ring.derive(p, "u") * q + p * ring.derive(q, "u")
    assert ring.derive(k, "u") == ring.zero


def test_derivative_beyond_the_highest_jet_is_refused(ring):
    with pytest.raises(KeyError, match="no u-derivative of f_u"):
        ring.derive(ring["f_u"], "u")


def test_conjugation_is_an_involution_that_swaps_and_conjugates(ring):
    p = ring.i * ring["f"] ** 2 * ring["k1"] + ring["g"]
    assert ring.conjugate(p) == -ring.i * ring["g"] ** 2 * ring["k1"] + ring["f"]
    assert ring.conjugate(ring.conjugate(p)) == p


def test_inverse_pairs_cancel(ring):
    k, k_inv, f = ring["k1"], ring["k1_inv"], ring["f"]
    assert ring.reduce(k**3 * k_inv**2 * f + k * k_inv) == k * f + 1


def test_rewrite_follows_chains_and_refuses_circles(ring):
    f, f_u, g = ring["f"], ring["f_u"], ring["g"]
    assert ring.rewrite(f_u**2, {f_u: 2 * g, g: f}) == 4 * f**2
    with pytest.raises(RuntimeError, match="circular"):
        ring.rewrite(f, {f: g, g: f})


def test_coefficient_and_parts_agree(ring):
    f, g, k = ring["f"], ring["g"], ring["k1"]
    p = k * f**2 + 2 * f * g + g - 5
    parts = ring.parts(p, [f])
    assert sum((m * c for m, c in parts.items()), ring.zero) == p
    assert ring.coefficient(p, f, [f]) == 2 * g == parts[f]
    assert ring.coefficient(p, ring.one, [f]) == g - 5


def test_expressions_enter_exactly_or_not_at_all(ring):
    p = from_expr(Rational(1, 3) * symbol("f") ** 2 + I * symbol("k1"), ring)
    assert p == ring["f"] ** 2 / 3 + ring.i * ring["k1"]
    with pytest.raises(ValueError, match="no such symbols here: mu"):
        from_expr(symbol("mu"), ring)
    with pytest.raises(ValueError, match="not a polynomial"):
        from_expr(sqrt(symbol("f")), ring)


def test_homomorphism_needs_an_image_for_every_generator(ring):
    small = jet_ring(["f"])
    assert (
        homomorphism(ring["f"] ** 2, {ring["f"]: small["f"] + 1}, small)
        == small["f"] ** 2 + 2 * small["f"] + 1
    )
    with pytest.raises(KeyError):
        homomorphism(ring["k1"], {}, small)
