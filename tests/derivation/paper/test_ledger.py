"""The ledger: every equation of the paper decided, every error seen, a wrong derivation seen too."""

from __future__ import annotations

from collections import Counter
from dataclasses import replace

import pytest

from derivation.adjoint import adjoint_problem
from derivation.corrections import second_order
from derivation.harmonics import first_order
from derivation.hierarchy import build_hierarchy
from derivation.paper.chain import changed
from derivation.paper.ledger import counts, decide, ledger
from derivation.paper.mutants import mutants
from derivation.paper.read import read
from derivation.paper.repair import repair
from derivation.paper.theory import Theory
from derivation.pipeline import derive
from derivation.resonance import third_order
from derivation.solvability import solvability

#: One display of each kind of comparison: exact laws, units, operators, expansions, conditions at both ends,
#: forcings by harmonics, corrections, transformed variables, cubic forcing, adjoint, integrals, amplitude.
REPRESENTATIVE = (
    "eq:definitions", "eq:drag", "eq:clamping", "eq:dimensionlessconstitutive", "inline nu",
    "eq:linearization", "eq:inner product", "eq:strainquadratic", "eq:velocityquadratic",
    "eq:dynamicsquadratic", "eq:followerquadratic", "eq:longitudinalforcingBC", "eq:longitudinalODE",
    "eq:ODEBCs", "after eq:pdefinitions", "eq:followercubic_geom", "eq:cubic_transform",
    "after eq:cubicforcing", "after eq:adjoint_eigenproblem", "eq:fredholm_condition", "eq:SL",
    "eq:saturated_amplitude", "eq:tipamplitude", "after eq:stuart_landau/4", "after eq:stuart_landau/5",
)  # fmt: skip


def display(equation):
    return equation.label.rpartition(".")[0] or equation.label


def one(text, notation, theory):
    """The single row of a display."""
    (row,) = ledger(read(rf"\[ {text} \]", notation).equations, notation, theory)
    return row


def test_every_equation_of_the_paper_is_decided_and_holds(paper, notation, theory):
    rows = ledger(paper.equations, notation, theory)
    assert counts(rows) == {"premise": 52, "verified": 167, "differs": 0, "not decided": 0}


@pytest.mark.parametrize("label", REPRESENTATIVE)
def test_every_error_is_reported_on_its_row_alone(label, paper, notation, theory):
    equations = [e for e in paper.equations if display(e) == label]
    assert equations
    found = list(mutants(equations, notation, theory))
    assert found
    missed = [(m.label, m.edit.kind, m.edit.old, m.edit.new) for m in found if m.outcome == "missed"]
    assert not missed
    assert Counter(m.outcome for m in found)["reported"] > 0


@pytest.mark.parametrize(
    ("text", "status"),
    [
        (r"h_1^{(2)} = \partial_u x^{(2)} + \theta^{(1)}(\partial_u y^{(1)} - \frac12 \nu \theta^{(1)})",
         "verified"),  # the printed form with h_2 written out
        (r"F_1^{(1)} = \tilde k_1 \partial_u x^{(1)}", "verified"),
        (r"h_1^{(2)} = x^{(2)'} + \theta^{(1)} y^{(1)\prime} - \frac{\nu}{2}(\theta^{(1)})^2", "verified"),
        (r"h_1^{(2)} = x^{(2)'} + \theta^{(1)} y^{(1)'} - \frac12 \nu \theta^{(1)2}", "verified"),
        (r"h_1^{(2)} = x^{(2)'} + \theta^{(1)} y^{(1)'} + \frac12 \nu \theta^{(1)2}", "differs"),
        (r"X_2'(1) = -\frac12 \nu \Theta^2(1)", "verified"),
        (r"\lambda = 2", "differs"),
        (r"\zeta = 2", "not decided"),
        (r"\mathcal{G} = 1", "differs"),
        (r"P_2(1) = 0", "verified"),
        (r"\Theta'' = i\omega_c\tilde\gamma_3\Theta - \mu H", "verified"),
        (r"\mu - \tilde{\mathcal F}_c = \tilde k_2 \nu", "verified"),
        (r"\nu = 1 - \mathcal F/k_2", "differs"),
    ],
)  # fmt: skip
def test_equations_that_the_paper_does_not_print(text, status, notation, theory):
    assert one(text, notation, theory).status == status


def test_expansions_are_decided_for_generic_fields(notation, theory):
    """x^(1) vanishes on the mode, yet a wrong coefficient in front of it is seen."""
    wrong = r"h_2^{(2)} = \partial_u y^{(2)} - \nu \theta^{(2)} - 2 \theta^{(1)} \partial_u x^{(1)}"
    assert one(wrong, notation, theory).status == "differs"


def test_the_same_in_other_letters(notation, theory):
    other = replace(notation, symbols={**notation.symbols, r"\kappa": "Pi"})
    assert one(r"\kappa^{(1)} = \partial_u \theta^{(1)}", other, theory).status == "verified"


@pytest.mark.parametrize(
    ("text", "kind", "edit"),
    [
        (r"g_4 = \frac{\mu}{\tilde k_1}(\Theta - \Theta(1)) - (1 - \frac{\tilde k_2}{\tilde k_1}) H",
         "sign", "for -"),
        (r"\Pi^{(3)} = 2\partial_u\theta^{(3)}", "factor", "for 2"),
        (r"P_2 = \tilde k_1 (X_2' + \Theta H + \frac{1}{3}\nu\Theta^2)",
         "number", r"\frac{1}{2} for \frac{1}{3}"),
        (r"P_0 = \tilde k_1 (X_0' + \Theta H + \frac{1}{2}\nu|\Theta|^2)",
         "added conjugate", r"\Theta^* for \Theta"),
        (r"v_1^{(2)} = \partial_\tau x^{(2)}", "missing term", r"\theta^{(1)} \partial_{\tau} y^{(1)}"),
        (r"\tilde\gamma_1 \partial_\tau x^{(1)} = \tilde k_2 \partial_u^2 x^{(1)}",
         "symbol", r"\tilde{k}_1 for"),
        (r"P_2 = \tilde k_1 (X_2 + \Theta H + \frac{1}{2}\nu\Theta^2)", "lost prime", "X_2' for X_2"),
    ],
)  # fmt: skip
def test_the_smallest_edit_is_found(text, kind, edit, notation, theory):
    row = one(text, notation, theory)
    assert row.status == "differs"
    found = repair(row, notation, theory)
    assert found is not None
    assert found.kind == kind
    assert edit in found.text
    (equation,) = read(rf"\[ {found.latex} \]", notation).equations
    assert decide(equation, notation, theory).status == "verified"


def test_a_condition_said_twice_leaves_one_out(notation, theory):
    text = r"\[ x^{(1)} = y^{(1)} = y^{(1)} = 0 \quad \mathrm{at}\ u = 0 \]"
    rows = ledger(read(text, notation).equations, notation, theory)
    assert [r.status for r in rows] == ["verified", "verified", "differs"]
    assert "none is there for theta" in rows[2].reason


def test_a_list_that_names_a_quantity_twice(notation, theory):
    assert one(r"X_0(u), \quad X_2(u)", notation, theory).status == "premise"
    assert one(r"X_0(u), \quad X_0(u)", notation, theory).status == "differs"


def _rederived(derivation, **kinematics):
    """The derivation with other expanded kinematics."""
    expanded = replace(derivation.kinematics, **kinematics)
    hierarchy = build_hierarchy(derivation.model, derivation.law, expanded)
    modes = first_order(hierarchy)
    second = second_order(hierarchy, modes)
    third = third_order(hierarchy, second)
    adjoint = adjoint_problem(hierarchy, second.modes)
    return replace(
        derivation, kinematics=expanded, hierarchy=hierarchy, modes=modes, second=second, third=third,
        adjoint=adjoint, landau=solvability(hierarchy, third, adjoint),
    )  # fmt: skip


def _without_one_term(series, order):
    """A series with one product of fields lost at one order."""
    p = series[order]
    monomial, coefficient = max(p.terms(), key=lambda term: sum(term[0]))
    return (*series[:order], p - p.ring.from_dict({monomial: coefficient}), *series[order + 1 :])


@pytest.mark.parametrize("order", [2, 3])
def test_a_lost_term_in_the_expansion_turns_the_ledger_red(order, paper, notation):
    d = derive()
    h1, h2, bend = d.kinematics.strains
    wrong = _rederived(d, strains=(_without_one_term(h1, order), h2, bend))
    label = {2: "eq:strainquadratic.1", 3: "eq:straincubic.1"}[order]
    red = [
        r.equation.label for r in ledger(paper.equations, notation, Theory(wrong)) if r.status == "differs"
    ]
    assert label in red


def test_a_wrong_sign_in_the_kinematics_turns_the_ledger_red(paper, notation):
    d = derive()
    v1, v2, spin = d.kinematics.velocities
    wrong = _rederived(d, velocities=(tuple(-p if n == 2 else p for n, p in enumerate(v1)), v2, spin))
    rows = ledger(paper.equations, notation, Theory(wrong))
    red = {r.equation.label for r in rows if r.status == "differs"}
    assert {"eq:velocityquadratic.1", "eq:dynamicsquadratic.1", "after eq:cubicforcing.1"} & red


@pytest.mark.parametrize(
    ("text", "link"),
    [
        (r"g_2 = \frac{i\omega_c}{\tilde k_1}\Theta(1) u", "g"),
        (r"P_2 = \tilde k_1 X_2'", "tension"),
        (r"\tilde k_1 X_2'' = 2 i\omega_c\tilde\gamma_1 X_2 + \Theta (i\omega_c\tilde\gamma_1 Y)",
         "forcing"),
        (r"X_0'(1) = -\nu |\Theta(1)|^2", "slope"),
    ],
)  # fmt: skip
def test_an_error_replaces_its_link_of_the_chain(text, link, notation, theory):
    from derivation.paper.chain import chain_of

    row = one(text, notation, theory)
    other = changed(row, notation, theory)
    assert not isinstance(other, str)
    derived = chain_of(theory.d)
    links = ("drag", "forcing", "slope", "tension", "g", "norm", "boundary", "whole")
    assert [name for name in links if getattr(other, name) != getattr(derived, name)] == [link]


def test_an_error_in_a_prediction_leaves_the_coefficients_alone(notation, theory):
    row = one(r"R_*^2 = \frac{\operatorname{Re}(\beta)}{\operatorname{Re}(\alpha)}\Delta", notation, theory)
    assert "do not depend on it" in changed(row, notation, theory)


NORM = r"\Psi_Y^* Y + \tilde\gamma_3\Psi_\Theta^*\Theta"
ALPHA, BETA = r"\Psi_Y^* g_1 + \Psi_\Theta^* g_3", r"\Psi_Y^* g_2 + \Psi_\Theta^* g_4"


def quotient(name, numerator, norm=NORM, after="", beside=""):
    """alpha or beta with its integrals; what stands after them is no part of the integrands."""
    above, below = (
        rf"\int_0^1 ({numerator}) \mathrm{{d}}u {after}",
        rf"\int_0^1 ({norm}) \mathrm{{d}}u {beside}",
    )
    return rf"\{name} = \frac{{{above}}}{{{below}}}"


@pytest.mark.parametrize(
    ("integrand", "derivative", "end"),
    [
        (BETA, r"(\Psi_Y^*)' \Theta + \Psi_Y^* \Theta'", r"\Psi_Y^*(1) \Theta(1)"),
        (BETA, r"\tilde k_2 (\Psi_Y^*)' \Theta(1) u + \tilde k_2 \Psi_Y^* \Theta(1)",
         r"\mu \Psi_\Theta^*(1) \Theta(1) - \mu\Psi_\Theta^*(1)\Theta(1) + \tilde k_2\Psi_Y^*(1)\Theta(1)"),
        (ALPHA, r"(\Psi_Y^*)' Y^2 Y^* + 2 \Psi_Y^* Y Y' Y^* + \Psi_Y^* Y^2 (Y^*)'", r"\Psi_Y^*(1)"),
        (ALPHA, r"(\Psi_Y^*)' X_2 \Theta^* + \Psi_Y^* X_2' \Theta^* + \Psi_Y^* X_2 (\Theta^*)'",
         r"\Psi_Y^*(1) X_2(1) \Theta^*(1)"),
        # with (Theta')' = i omega gamma3 Theta - mu H and Theta'(1) = 0, but Psi_Theta'(0) Theta'(0) stays
        (BETA, r"(\Psi_\Theta^*)'' \Theta' + (\Psi_\Theta^*)' (i\omega_c\tilde\gamma_3\Theta - \mu H)",
         r"(-(\Psi_\Theta^*)'(0) \Theta'(0))"),
    ],
)  # fmt: skip
def test_integrals_are_equal_up_to_integration_by_parts(integrand, derivative, end, notation, theory):
    name = "alpha" if integrand == ALPHA else "beta"
    moved = f"{integrand} + {derivative}"
    right = one(quotient(name, moved, after=f"- ({end})"), notation, theory)
    assert (right.status, right.difference.terms) == ("verified", {})
    for after in ("", f"+ ({end})", f"- 2 ({end})"):  # the boundary term lost, its sign, its factor
        assert one(quotient(name, moved, after=after), notation, theory).status == "differs"
    assert one(
        quotient(name, f"{integrand} - {derivative}", after=f"- ({end})"), notation, theory
    ).status == ("differs")


def test_a_derivative_of_what_vanishes_at_both_ends_may_be_added(notation, theory):
    moved = BETA + r" + (\Psi_Y^*)' \Theta' + \Psi_Y^* (i\omega_c\tilde\gamma_3\Theta - \mu H)"
    assert one(quotient("beta", moved), notation, theory).status == "verified"
    assert one(quotient("beta", moved.replace(r"- \mu H", r"+ \mu H")), notation, theory).status == "differs"


def test_the_norm_may_be_integrated_by_parts(notation, theory):
    norm = NORM + r" + (\Psi_Y^*)' \Theta + \Psi_Y^* \Theta'"
    end = r"\Psi_Y^*(1) \Theta(1)"
    assert one(quotient("alpha", ALPHA, norm, beside=f"- {end}"), notation, theory).status == "verified"
    assert one(quotient("alpha", ALPHA, norm, beside=f"+ {end}"), notation, theory).status == "differs"


@pytest.mark.parametrize(
    ("after", "kind", "text"),
    [
        (r"+ \Psi_Y^*(1) \Theta(1)", "sign", r"-\Psi_Y^*(1) \Theta(1) for \Psi_Y^*(1) \Theta(1)"),
        ("", "missing term", r"add -\Psi_Y^*(1) \Theta(1) in the numerator"),
    ],
)
def test_a_wrong_boundary_term_is_named(after, kind, text, paper, notation, theory):
    moved = BETA + r" + (\Psi_Y^*)' \Theta + \Psi_Y^* \Theta'"
    row = one(quotient("beta", moved, after=after), notation, theory)
    found = repair(row, notation, theory)
    assert not any(a.kind == "integral" for a in row.difference.atoms)
    assert (found.kind, text in found.text) == (kind, True)
    assert not isinstance(changed(row, notation, theory), str)
    whole = [replace(e, body=row.equation.body) if e.label == "eq:alphabetaformulas.2" else e
             for e in paper.equations if display(e) == "eq:alphabetaformulas"]  # fmt: skip
    assert [r.status for r in ledger(whole, notation, theory)] == ["verified", "differs"]
