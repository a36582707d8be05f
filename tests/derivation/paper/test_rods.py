"""The paper's equations against other rods: each row gets a status, with the reason where there is none."""

from __future__ import annotations

from dataclasses import replace
from functools import cache
from pathlib import Path

import pytest

from derivation.model import MODELS
from derivation.modelfile import read_model
from derivation.paper.kinds import grouped, stage_of
from derivation.paper.ledger import counts, ledger
from derivation.paper.read import read
from derivation.paper.theory import Theory
from derivation.paper.typeset import latex
from derivation.paper.verify import derived_form
from derivation.pipeline import derive

TIP_DRAG = Path(__file__).parents[3] / "examples" / "tip_drag.toml"
#: Premises, verified, differs, not decided, of the bundled equations.
EXPECTED = {
    "metric_drag": (45, 126, 39, 9),
    "quartic": (51, 139, 27, 2),
    "partial_follower": (50, 125, 18, 26),
    "distributed": (49, 130, 40, 0),
    "tip_drag": (49, 113, 33, 24),
}
RODS = [*EXPECTED]


@cache
def theory_of(name: str) -> Theory:
    return Theory(
        derive(MODELS[name] if name in MODELS else read_model(TIP_DRAG.read_text(encoding="utf-8")))
    )


def decided(text, notation, theory):
    (row,) = ledger(read(rf"\[ {text} \]", notation).equations, notation, theory)
    return row


def test_every_shipped_rod_is_here():
    assert {*MODELS, "tip_drag"} == {"follower", *RODS}


def test_the_documentation_gives_these_counts():
    text = (TIP_DRAG.parents[1] / "docs" / "your-rod.md").read_text(encoding="utf-8")
    for name, numbers in EXPECTED.items():
        shown = f"examples/{name}.toml" if name == "tip_drag" else name.replace("_", "-")
        assert f"| `{shown}` | " + " | ".join(map(str, numbers)) in text


@pytest.mark.parametrize("name", RODS)
def test_the_papers_equations_for_another_rod(name, paper, notation):
    theory = theory_of(name)
    rows = ledger(paper.equations, notation, theory)
    assert tuple(counts(rows).values()) == EXPECTED[name]
    for row in rows:
        assert row.reason
        assert grouped(row.equation, notation, theory)
        assert stage_of(row.equation, notation, theory)
        form = derived_form(row.equation, notation, theory)
        assert form is None or "K1" not in latex(form)


@pytest.mark.parametrize("name", RODS)
def test_alpha_and_beta_exist_for_every_rod(name, notation):
    """As derived they are read and hold; with another end term they do not."""
    theory = theory_of(name)
    law = theory.d.law
    own = {rf"\mathrm{{{q}}}": q for q in (*law.parameters[5:], *law.constants)}
    letters = replace(notation, symbols={**notation.symbols, **own})
    for coefficient in (r"\alpha", r"\beta"):
        unknown = read(rf"\[ {coefficient} = 0 \]", letters).equations[0]
        form = latex(derived_form(unknown, letters, theory))
        assert decided(f"{coefficient} = {form}", letters, theory).status == "verified"
        assert decided(rf"{coefficient} = {form} + \Psi_Y^*(1)", letters, theory).status == "differs"


@pytest.mark.parametrize(
    ("name", "text", "status", "reason"),
    [
        ("partial_follower", r"g_4 = H", "not decided", "there are no transformed variables"),
        ("metric_drag", r"f_1 = -\gamma_1 v_1", "not decided", "is no polynomial"),
        ("metric_drag", r"F_1 = k_1 (h_1 - 1)", "verified", ""),
        # a fraction of the load follows, the rest keeps its direction
        ("partial_follower", r"F_2(L, t) = 0", "differs", ""),
        ("tip_drag", r"\Theta'(1) = -\mathrm{spring} \Theta(1) - i \omega_c \mathrm{damper} \Theta(1)",
         "verified", ""),
        ("tip_drag", r"\Theta'(1) = -\mathrm{spring} \Theta(1) - \mathrm{damper} \Theta(1)", "differs", ""),
        # nu is 1 at the tip of a rod that is loaded along it, and changes towards the clamp
        ("distributed", r"Y'(1) = \Theta(1)", "verified", ""),
        ("distributed", r"\nu = 1 - \frac{\tilde{\mathcal{F}}}{\tilde{k}_1}(1 - u)", "verified", ""),
        ("distributed", r"\nu = 1 - \frac{\tilde{\mathcal{F}}}{\tilde{k}_1}", "differs", ""),
        ("distributed", r"\partial_u \nu = \frac{\tilde{\mathcal{F}}}{\tilde{k}_1}", "verified", ""),
    ],
)  # fmt: skip
def test_what_a_rod_has_of_its_own(name, text, status, reason, notation):
    own = {rf"\mathrm{{{q}}}": q for q in ("spring", "damper")}
    letters = replace(notation, symbols={**notation.symbols, **own})
    row = decided(text, letters, theory_of(name))
    assert row.status in (status, "premise") if status == "verified" else row.status == status
    assert reason in row.reason
