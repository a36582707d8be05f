"""`rodwnl verify`: exit codes, JSON, single rows, the page, bad files; what an error does to α and β."""

import json
import re

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
