"""`rodwnl verify`: exit codes, JSON, single rows, the page, bad files; what an error does to α and β."""

import json
import re
from pathlib import Path

import pytest

from rodwnl import cli
from rodwnl.effects import points

RIGHT = r"""
\begin{equation}
  g_4 = \frac{\mu}{\tilde{k}_1}\left(\Theta - \Theta(1)\right)
  + \left(1 - \frac{\tilde{k}_2}{\tilde{k}_1}\right) H
  \label{eq:g4}
\end{equation}
"""
TABLE = r"""
\begin{table}
\begin{tabular}{ccccc}
Figure & $\tilde{k}_{1}$ & $\tilde{k}_{2}$ & $\tilde{\gamma}_{3}$ & $\tilde{\mathcal{F}}_c$ \\
(a) & $2\times 10^{2}$ & $10^{4}$ & $10^{-4}$ & $CELL$ \\
\end{tabular}
\label{tab:forces}
\end{table}
"""


@pytest.fixture
def source(tmp_path):
    def write(text, name="paper.tex"):
        path = tmp_path / name
        path.write_text(text, encoding="utf-8")
        return str(path)

    return write


def run(capsys, *arguments):
    code = cli.run(["verify", *arguments])
    out, err = capsys.readouterr()
    return code, out, err


def document(capsys, *arguments):
    code, out, _ = run(capsys, "--json", *arguments)
    return code, json.loads(out)


def test_a_rod_along_which_more_varies_than_nu_and_mu_is_refused(capsys):
    file = Path(__file__).parents[2] / "examples" / "loaded.toml"
    code, out, err = run(capsys, "--model", str(file))
    assert (code, out) == (2, "")
    assert re.fullmatch(r".*loaded\.toml': along it more than its stretch varies, or .*\n", err)


def test_the_bundled_equations_hold(capsys):
    code, found = document(capsys)
    assert code == 0
    assert found["counts"]["differs"] == found["counts"]["not decided"] == 0
    assert found["counts"]["verified"] > 150
    assert found["counts"]["tables"]["differs"] == 0
    assert len({e["label"] for e in found["equations"]}) == len(found["equations"])
    assert all(c["agreement"] >= 9 for c in found["tables"] if not c["method"])


def test_the_summary_is_one_screen(capsys):
    code, out, _ = run(capsys)
    assert code == 0
    assert len(out.splitlines()) < 30


def test_a_right_equation_alone(capsys, source):
    code, found = document(capsys, "--tex", source(RIGHT))
    assert code == 0
    (row,) = found["equations"]
    assert (row["label"], row["line"], row["status"]) == ("eq:g4.1", 2, "verified")
    assert row["difference"] is row["edit"] is row["effect"] is None


def test_a_wrong_sign_is_shown_repaired_and_weighed(capsys, source):
    code, found = document(capsys, "--tex", source(RIGHT.replace("+ \\left(1", "- \\left(1")))
    assert code == 1
    (row,) = found["equations"]
    assert row["status"] == "differs"
    assert row["difference"] == r"2 H - \frac{2 \tilde{k}_2 H}{\tilde{k}_1}"
    assert row["edit"].endswith(r"for -\left(1 - \frac{\tilde{k}_2}{\tilde{k}_1}\right) H")
    rods = {r["row"]: r for r in row["effect"]["rods"]}
    assert rods["(a, b)"]["beta"] == "0"  # k1 = k2 there
    assert float(rods["(e, f)"]["beta"]) > 0.1
    assert {r["alpha"] for r in rods.values()} == {"0"}


@pytest.mark.parametrize(
    ("equation", "effect"),
    [
        (r"v_2^{(2)} = \partial_u F_1^{(2)} - \tilde{\mathcal{F}}_c \Pi^{(2)}", "no theory follows"),
        (r"\partial_u x^{(2)} = 0", "no theory follows"),
        (r"y^{(2)} = A^2 X_2 e^{2 i \omega_c \tau} + |A|^2 X_0 + \mathrm{c.c.}", "no theory follows"),
        (r"\Pi^{(2)} = \partial_u \theta^{(2)} + (\theta^{(1)})^2", "not symmetric under reflection"),
    ],
)
def test_an_error_that_leaves_no_theory_is_said_in_a_phrase(equation, effect, capsys, source):
    path = source(rf"\begin{{equation}}{equation}\label{{eq:wrong}}\end{{equation}}")
    code, found = document(capsys, "--tex", path)
    assert code == 1
    (row,) = found["equations"]
    assert (row["status"], row["effect"]["rods"]) == ("differs", [])
    assert effect in row["effect"]["note"]


def test_details_of_one_equation(capsys, source):
    code, out, _ = run(capsys, "--tex", source(RIGHT), "--show", "eq:g4")
    assert code == 0
    for part in ("eq:g4.1, line 2: verified", "printed", "read as", "derived", "derivation/resonance.py"):
        assert part in out


def test_one_label_of_many(capsys):
    code, found = document(capsys, "--only", "eq:follower.2")
    assert code == 0
    assert [e["label"] for e in found["equations"]] == ["eq:follower.2"]
    assert found["tables"] == []
    _, found = document(capsys, "--only", "tab:parameters")
    assert {c["label"] for c in found["tables"]} == {"tab:parameters"}


@pytest.mark.parametrize(
    ("cell", "code", "status"),
    [("49.76", 0, "numeric"), ("49.77", 1, "differs"), ("155.60", 0, "numeric"), ("155.6", 0, "numeric")],
)
def test_a_cell_of_another_table(cell, code, status, capsys, source):
    got, found = document(capsys, "--tex", source(TABLE.replace("CELL", cell)))
    assert got == code
    assert [c["status"] for c in found["tables"]] == [status]


def test_other_letters(capsys, source):
    letters = source("[symbols]\n'q_4' = 'g4'\n", "letters.toml")
    code, found = document(capsys, "--tex", source(RIGHT.replace("g_4", "q_4")), "--notation", letters)
    assert code == 0
    assert found["counts"]["verified"] == 1


def test_the_page_stands_alone(capsys, source, tmp_path):
    page = tmp_path / "ledger.html"
    code, _, _ = run(capsys, "--tex", source(RIGHT.replace("+ \\left(1", "- \\left(1")), "--html", str(page))
    assert code == 1
    text = page.read_text(encoding="utf-8")
    assert "<math" in text
    assert 'class="row differs"' in text
    assert not re.search(r"(?:src|href)=", text)
    assert list(tmp_path.glob("*.part")) == []


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("\\[ x = (y \\]", r"paper\.tex, line 1: \( is not closed"),
        ("\n\\begin{equation}\nx = y\n", r"line 2: .*expected \\end\{equation\}"),
        ("\\[ x = \\foo \\]", r"unknown command \\foo"),
        (TABLE.replace("CELL", "many"), "expected a number such as 7.35"),
        ("", r"paper\.tex: no displayed equation found; looked for \\begin\{equation\}"),
        ("Nothing $x = y$ displayed.", "no displayed equation found"),
        ("\\[\nY = H^{(1)+2} \\]", r"line 2: the superscript \( 1 \) \+ 2 is neither an order"),
    ],
)
def test_a_broken_source_is_one_line(text, message, capsys, source):
    code, out, err = run(capsys, "--tex", source(text))
    assert (code, out) == (2, "")
    assert re.search(message, err)
    assert err.count("\n") == 1


def test_an_unknown_label_and_a_missing_file(capsys, tmp_path):
    code, _, err = run(capsys, "--only", "eq:folower.2")
    assert code == 2
    assert "near it are eq:follower.2" in err
    assert run(capsys, "--tex", str(tmp_path / "none.tex"))[0] == 2


def test_another_rod_does_not_obey_the_papers_equations(capsys):
    code, found = document(capsys, "--model", "metric_drag", "--only", "eq:longitudinalforcing")
    assert code == 1
    assert {e["status"] for e in found["equations"]} == {"differs"}


def test_a_rod_without_transformed_variables(capsys, source):
    """g4 is not decided for it, and says why; the printed law of the drag is."""
    law = r"\[ f_1 = -\gamma_1 v_1 \]"
    code, found = document(capsys, "--model", "partial-follower", "--tex", source(RIGHT + law))
    assert code == 0
    g4, drag = found["equations"]
    assert (g4["status"], drag["status"]) == ("not decided", "premise")
    assert "no transformed variables" in g4["reason"]


def test_a_law_that_is_no_polynomial(capsys):
    code, found = document(capsys, "--model", "metric-drag", "--only", "eq:drag")
    assert code == 0
    reasons = {e["reason"] for e in found["equations"] if e["status"] == "not decided"}
    assert reasons == {
        "metric_drag: gamma1*v1*sqrt(h1**2 + h2**2) is no polynomial, and only those are compared"
    }


@pytest.mark.parametrize(
    "command", [["verify"], ["derive", "--show", "g1"], ["export", "-", "--format", "c"]]
)
def test_a_rod_outside_the_theory_is_one_line(command, capsys, source):
    text = """name = "coupled"
title = "a rod that couples shear and bending"
energy = "k1*(h1 - 1)^2/2 + k2*h2^2/2 + Pi^2/2 + h2*Pi"
drag = { v1 = "gamma1", v2 = "1", Omega = "gamma3" }
load = [{ kind = "follower" }]
"""
    code = cli.run([*command, "--model", source(text, "coupled.toml")])
    out, err = capsys.readouterr()
    assert (code, out, err.count("\n")) == (2, "", 1)
    assert "couples shear and bending" in err


def test_control_characters_are_shown_escaped(capsys, source):
    text = "\\begin{equation}\\label{eq:\x1b[31mred\x07}Y = H\\end{equation}"
    path = source(text, "odd.tex")
    for options in ([], ["--show", "eq:\x1b[31mred\x07"], ["--only", "eq:red"]):
        _, out, err = run(capsys, "--tex", path, *options)
        assert r"eq:\x1b[31mred\x07" in out + err
        assert not {"\x1b", "\x07"} & set(out + err)


def test_one_wrong_coefficient_takes_few_trials(monkeypatch, capsys, source):
    """Of a row with integrals at most so many edits are tried: each takes tens of milliseconds."""
    from derivation.paper import repair

    tried = []
    monkeypatch.setattr(repair, "TRIALS_OF_INTEGRALS", 5)
    monkeypatch.setattr(repair, "holds", lambda equation, *_: bool(tried.append(equation)))
    wrong = r"\[ \beta = \frac{\int_0^1 Y \mathrm{d}u}{\int_0^1 H \mathrm{d}u} \]"
    assert run(capsys, "--tex", source(wrong))[0] == 1
    assert 5 <= len(tried) <= 7  # and the missing term, on the right or in the numerator


def test_the_chain_gives_the_coefficients():
    """The chain evaluated as derived is the theory that `landau` evaluates."""
    from derivation.paper.chain import chain_of
    from derivation.pipeline import derive
    from rodwnl.effects import _coefficients
    from rodwnl.tables import compared_rows

    chain = chain_of(derive())
    for point, (row, cells) in zip(points(), compared_rows(), strict=False):
        values = {c.column: c.value for c in cells}
        assert point.name == row.name
        alpha, beta = _coefficients(chain, point)
        assert alpha == pytest.approx(values["alpha"], rel=1e-7)
        assert beta == pytest.approx(values["beta"], rel=1e-9)
