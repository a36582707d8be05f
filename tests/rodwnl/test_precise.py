"""`--digits` and `--certified` of the commands hopf and landau, run as a user runs them."""

import json
import sys

import mpmath as mp
import pytest

from rodwnl import RodParameters, cli
from rodwnl.exact import exact_threshold

REENTRANT = ["--k1", "200", "--k2", "1e4", "--gamma3", "1e-4"]
QUIET = ["--k1", "20", "--k2", "1e4", "--gamma3", "1e-4"]
# 50 digits of the lower threshold, from a working precision of 150 digits
FORCE = "49.758004916191500360604113836383720457483659696360"
RE_ALPHA = "-2183.5610531835636855708068176887671795092280666608"


@pytest.fixture
def said(capsys):
    def run(*arguments, code=0):
        assert cli.run(arguments) == code
        out, err = capsys.readouterr()
        assert err == "" if code != 2 else out == "" and err.count("\n") == 1
        return err if code == 2 else out

    return run


def test_fifty_digits_in_the_table_and_in_json(said):
    table = said("landau", *REENTRANT, "--digits", "50")
    assert FORCE in table
    assert RE_ALPHA in table
    lower, upper = json.loads(said("landau", *REENTRANT, "--digits", "50", "--json"))["thresholds"]
    assert lower["force"] == FORCE
    assert lower["alpha"][0] == RE_ALPHA
    assert (lower["criticality"], upper["criticality"]) == ("supercritical", "subcritical")
    assert lower["digits_that_agree"] >= 52


def test_digits_do_not_change_when_more_are_asked_for():
    rod = RodParameters(200, "1e4", "1e-4")
    with mp.workdps(150):
        exact = exact_threshold(rod, 49.76, 334.32, 120)
        assert mp.nstr(exact.force, 50, strip_zeros=False) == FORCE
        assert mp.nstr(exact.alpha.real, 50, strip_zeros=False) == RE_ALPHA


@pytest.mark.parametrize("digits", ["1", "7", "33"])
def test_as_many_digits_as_asked_for(said, digits):
    entry = json.loads(said("hopf", *REENTRANT, "--digits", digits, "--json"))["thresholds"][0]
    assert "alpha" not in entry
    with mp.workdps(60):
        expected = mp.nstr(mp.mpf(FORCE), int(digits), strip_zeros=False)
    assert entry["force"] == expected


def test_certified_json_has_balls_and_statements(said):
    document = json.loads(said("landau", *REENTRANT, "--certified", "--digits", "30", "--json"))
    assert document["certified"] is True
    lower, upper = document["thresholds"]
    with mp.workdps(60):
        for ball, text in ((lower["force"], FORCE), (lower["alpha"][0], RE_ALPHA)):
            assert abs(mp.mpf(ball["mid"]) - mp.mpf(text)) <= mp.mpf(ball["rad"])
            assert mp.mpf(ball["rad"]) < 1e-28 * abs(mp.mpf(ball["mid"]))
    assert set(lower["unique_in"]) == {"force", "omega"}
    assert [t["unstable_eigenvalues"] for t in (lower, upper)] == [0, 0]
    assert "Re alpha > 0: the bifurcation is subcritical" in upper["proved"]


def test_certified_table_lists_what_was_proved(said):
    text = said("hopf", *REENTRANT, "--certified")
    assert text.count("Proved of it") == 2
    assert "one and only one pair" in text
    assert "49.7580049161915 ±" in text


def test_digits_in_si_units_are_exact(said):
    # L = 2, k3 = 3, gamma2 = 5: force scale 3/4
    si = ["--k1", "150", "--k2", "7500", "--gamma3", "0.002", "--length", "2", "--k3", "3", "--gamma2", "5"]
    table = said("hopf", *si, "--digits", "30")
    with mp.workdps(40):
        force = mp.nstr(mp.mpf(FORCE) * 3 / 4, 30, strip_zeros=False)
    assert f"force (N)   {force}" in table


def test_a_rod_that_stays_stable_has_nothing_to_refine(said):
    document = json.loads(said("landau", *QUIET, "--digits", "40", "--json"))
    assert document["thresholds"] == []
    assert "stable in the whole range" in said("landau", *QUIET, "--certified")


@pytest.mark.parametrize("digits", ["0", "-3", "10000000", "2.5", "many", ""])
def test_digits_out_of_range_are_one_clear_line(said, digits):
    assert "whole number from 1 to 10000" in said("landau", *REENTRANT, "--digits", digits, code=2)


def test_certified_without_the_extra_says_what_to_install(said, monkeypatch):
    monkeypatch.setitem(sys.modules, "flint", None)
    assert "pip install 'rodwnl[certified]'" in said("landau", *REENTRANT, "--certified", code=2)


def test_reproduce_prints_digits_of_every_threshold_once(said):
    document = json.loads(said("reproduce", "--tables", "--digits", "30", "--json"))
    assert [entry["row"] for entry in document["exact"]] == ["(a, b)", "(c, d)", "(e, f)", "(g, h)"]
    with mp.workdps(60):
        assert document["exact"][2]["force"] == mp.nstr(mp.mpf(FORCE), 30, strip_zeros=False)
    assert FORCE[:20] in said("reproduce", "--tables", "--digits", "30")
    assert "whole number from 1 to 10000" in said("reproduce", "--tables", "--digits", "0", code=2)
