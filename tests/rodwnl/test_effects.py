"""What a printed equation does to the numbers: an equation that holds changes none of them."""

from __future__ import annotations

from dataclasses import replace

import pytest

from derivation.paper.algebra import Atom, atom
from derivation.paper.chain import chain_of
from derivation.paper.meanings import integral
from derivation.paper.theory import Theory
from derivation.pipeline import derive
from rodwnl.effects import _coefficients, points


def shape(name, u=0, bar=False, place=None):
    return atom(Atom("shape", name, u=u, bar=bar, place=place))


def test_beta_after_integration_by_parts_is_the_same_number():
    theory = Theory(derive())
    chain = chain_of(theory.d)
    # q = Psi_Theta'^* Theta' has end values at u = 0 alone, and Psi_Theta'' by the adjoint equations
    q = shape("Psi_Theta", 1, bar=True) * shape("Theta", 1)
    slope = theory.canonical(theory.by_equations(q.derive("u")))
    ends = q.at(1) - q.at(0)
    moved = theory.landau["beta"] + (integral(slope) - ends) * theory.norm.inverse()
    for point in points()[:2]:
        alpha, beta = _coefficients(chain, point)
        again = _coefficients(replace(chain, whole={"beta": moved}), point)
        assert again == (alpha, pytest.approx(beta, rel=1e-8))
        lost = theory.landau["beta"] + integral(slope) * theory.norm.inverse()
        assert _coefficients(replace(chain, whole={"beta": lost}), point)[1] != pytest.approx(beta, rel=1e-3)
