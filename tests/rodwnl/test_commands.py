"""The commands hopf, landau, predict and reproduce, run as a user runs them."""

import json
import re
import subprocess
import sys

import pytest

from rodwnl import RodParameters, cli, tables
from rodwnl.coefficients import landau
from rodwnl.tables import compared_rows

REENTRANT = ["--k1", "200", "--k2", "1e4", "--gamma3", "1e-4"]
WRONG = tables.Erratum("tab:parameters", "(a, b)", "force", "37.66", "37.67", "")
QUIET = ["--k1", "20", "--k2", "1e4", "--gamma3", "1e-4"]


@pytest.fixture
def said(capsys):
    def run(*arguments, code=0):
        assert cli.run(arguments) == code
        out, err = capsys.readouterr()
        assert err == "" if code != 2 else out == "" and err.count("\n") == 1
        return err if code == 2 else out

    return run


def lines_of(text):
    return {line.split()[0]: line.split()[1:] for line in text.splitlines() if line.strip()}


def test_hopf_finds_both_thresholds_of_the_reentrant_rod(said):
    document = json.loads(said("hopf", *REENTRANT, "--json"))
    assert document["rod"] == {"k1": "200", "k2": "10000", "gamma3": "0.0001", "gamma1": "0.5"}
    assert document["range"] == ["0", "200"]
    lower, upper = document["thresholds"]
    assert float(lower["force"]) == pytest.approx(49.7580049161915003606, rel=1e-14)
    assert float(upper["force"]) == pytest.approx(155.600159298790666428, rel=1e-14)
    assert (lower["crossing"], upper["crossing"]) == ("destabilizing", "restabilizing")
    assert "alpha" not in lower


def test_landau_prints_what_the_library_computes(said):
    expected = landau(RodParameters(200, "1e4", "1e-4"))
    document = json.loads(said("landau", *REENTRANT, "--json"))
    assert len(document["thresholds"]) == 2
    for entry, c in zip(document["thresholds"], expected, strict=True):
        assert complex(*map(float, entry["alpha"])) == c.alpha
        assert complex(*map(float, entry["beta"])) == c.beta
        for name in ("force", "omega", "A_tip2_slope", "omega_slope"):
            assert float(entry[name]) == getattr(c, name)
        assert (entry["criticality"], entry["crossing"]) == (c.criticality, c.crossing)
        assert entry["residuals"].keys() == c.residuals.keys() | {"threshold"}
        assert float(entry["residuals"]["threshold"]) == c.threshold.residual
    assert [t["criticality"] for t in document["thresholds"]] == ["supercritical", "subcritical"]


def test_landaus_table_has_a_column_for_each_threshold(said):
    shown = lines_of(said("landau", *REENTRANT))
    assert shown["threshold"] == ["1", "2"]
    assert shown["criticality"] == ["supercritical", "subcritical"]
    # every printed digit agrees with 30-digit values
    exact = {
        "force": ["49.7580049161915", "155.600159298790"],
        "omega": ["334.321465737703", "3367.28095759683"],
    }
    for name, values in exact.items():
        for text, value in zip(shown[name], values, strict=True):
            assert abs(float(text) - float(value)) <= 10.0 ** -len(text.partition(".")[2])


def test_si_units_scale_every_printed_quantity(said):
    plain = json.loads(said("landau", "--k1", "500", "--k2", "1000", "--gamma3", "2e-4", "--json"))
    # L = 0.1, k3 = 2e-4, γ2 = 0.5: force k3/L² = 0.02, time γ2 L⁴/k3 = 0.25
    si = [
        "--k1",
        "10",
        "--k2",
        "20",
        "--gamma3",
        "1e-6",
        "--length",
        "0.1",
        "--k3",
        "2e-4",
        "--gamma2",
        "0.5",
    ]
    document = json.loads(said("landau", *si, "--json"))
    assert document["thresholds"] == plain["thresholds"]
    assert document["scales"] == {"length": "0.1", "time": "0.25", "force": "0.02"}
    shown = lines_of(said("landau", *si))
    (c,) = plain["thresholds"]
    scaled = {
        "force": float(c["force"]) * 0.02,
        "omega": float(c["omega"]) / 0.25,
        "alpha": float(c["alpha"][0]) / 0.25 / 0.01,
        "beta": float(c["beta"][0]) / 0.25 / 0.02,
        "A_tip2_slope": float(c["A_tip2_slope"]) * 0.01 / 0.02,
        "omega_slope": float(c["omega_slope"]) / 0.25 / 0.02,
    }
    for name, value in scaled.items():
        number = next(word for word in shown[name] if re.fullmatch(r"-?[\d.]+", word))
        assert float(number) == pytest.approx(value, rel=1e-9), name
    assert "<= 0.5 N" in said("hopf", *si, "--max-force", "0.5")


@pytest.mark.parametrize("command", ["hopf", "landau"])
def test_no_threshold_is_an_answer(said, command):
    text = said(command, *QUIET)
    assert "No Hopf threshold: the straight rod is stable in the whole range" in text
    assert "0 <= force <= 20" in text
    document = json.loads(said(command, *QUIET, "--json"))
    assert (document["thresholds"], document["range"]) == ([], ["0", "20"])
    assert any("No Hopf threshold" in note for note in document["notes"])


@pytest.mark.parametrize("command", ["hopf", "landau"])
def test_a_range_beyond_k1_is_cut_and_said_to_be(said, command):
    assert "force = k1" in said(command, *REENTRANT, "--max-force", "1e3")
    document = json.loads(said(command, *REENTRANT, "--max-force", "1e3", "--json"))
    assert document["range"] == ["0", "200"]
    assert "force = k1" not in said(command, *REENTRANT, "--max-force", "100")


@pytest.mark.parametrize("command", ["hopf", "landau"])
@pytest.mark.parametrize("bad", ["-1", "nan", "x", ""])
def test_a_bad_range_is_refused(said, command, bad):
    assert "max_force is " in said(command, *REENTRANT, "--max-force", bad, code=2)


def test_predict_tells_each_side_of_each_threshold(said):
    def branches(force):
        document = json.loads(said("predict", *REENTRANT, "--force", force, "--json"))
        assert document["force"] == force
        return [(p["side"], p["exists"], p["stable"], p["A_tip"] is None) for p in document["predictions"]]

    none = ("above", False, None, True)
    assert branches("49") == [none, none]
    assert branches("52") == [("above", True, True, False), none]
    assert branches("160") == [("above", True, True, False), ("above", True, False, False)]


def test_predict_follows_the_slopes(said):
    (c, _) = landau(RodParameters(200, "1e4", "1e-4"))
    p = json.loads(said("predict", *REENTRANT, "--force", "50", "--json"))["predictions"][0]
    assert float(p["A_tip"]) ** 2 == pytest.approx(c.A_tip2_slope * (50 - c.force), rel=1e-12)
    assert float(p["omega"]) == pytest.approx(c.omega + c.omega_slope * (50 - c.force), rel=1e-14)


def test_predict_prints_a_row_for_each_threshold(said):
    text = said("predict", *REENTRANT, "--force", "52")
    assert "none here: it lies above the threshold" in text
    assert " stable " in text
    assert "nothing to predict" in said("predict", *QUIET, "--force", "5")


@pytest.mark.parametrize("force", ["-1", "200", "nan", ""])
def test_predict_refuses_a_force_without_a_straight_rod(said, force):
    assert "force is " in said("predict", *REENTRANT, "--force", force, code=2)


def test_reproduce_shows_every_cell_as_printed_and_as_computed(said):
    text = said("reproduce", "--tables")
    for row, cells in compared_rows():
        for cell in cells:
            assert cell.computed in text
        for printed in row.cells.values():
            assert printed in text
    assert ", 0 differs" in text


def test_reproduce_in_json(said):
    document = json.loads(said("reproduce", "--tables", "--json"))
    statuses = [cell["status"] for cell in document["tables"]]
    assert document["counts"] == {name: statuses.count(name) for name in ("numeric", "erratum", "differs")}
    assert len(statuses) == 8 * 4 + 8
    assert {cell["column"] for cell in document["tables"] if cell["status"] == "erratum"} == {"alpha"}


@pytest.mark.parametrize(
    ("change", "reason"),
    [
        (lambda errata: errata[1:], "not a reviewed erratum"),
        (lambda errata: (*errata, WRONG), "(37.66 should be 37.67) does not hold"),
    ],
)
def test_reproduce_fails_for_what_the_errata_do_not_cover(said, monkeypatch, change, reason):
    changed = change(tables.errata())
    monkeypatch.setattr(tables, "errata", lambda: changed)
    compared_rows.cache_clear()
    try:
        text = said("reproduce", "--tables", code=1)
    finally:
        compared_rows.cache_clear()
    assert "DIFFERS" in text
    assert reason in text


def test_no_command_but_derive_imports_sympy_and_landau_not_even_scipy():
    code = f"import sys; from rodwnl.cli import run; run(['landau', *{REENTRANT}]); print(*sys.modules)"
    loaded = subprocess.run(
        [sys.executable, "-c", code], capture_output=True, text=True, check=True
    ).stdout.split()
    assert "numpy" in loaded
    assert not {"sympy", "scipy", "matplotlib", "derivation"} & set(loaded)


def test_hopf_lists_the_crossings_of_further_eigenvalues_when_asked(said):
    rod = ["--k1", "1e4", "--k2", "1e4", "--gamma3", "1e-4"]
    document = json.loads(said("hopf", *rod, "--all", "--json"))
    (later,) = document["later"]
    assert (later["unstable_below"], later["unstable_above"]) == (2, 4)
    assert float(later["force"]) > float(document["thresholds"][0]["force"])
    assert "later" not in json.loads(said("hopf", *rod, "--json"))
    assert "Further eigenvalues" in said("hopf", *rod, "--all")
    assert "No further eigenvalue" in said("hopf", *REENTRANT, "--all")
    assert "--all" in said("hopf", *rod, "--all", "--digits", "20", code=2)
