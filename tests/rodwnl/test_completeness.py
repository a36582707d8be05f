"""The proof that no threshold is missing: it succeeds, counts, and fails where a threshold is withheld."""

import json
from dataclasses import replace
from fractions import Fraction

import mpmath as mp
import pytest

pytest.importorskip("flint", reason="python-flint, the extra `certified`, is not installed")

from rodwnl import RodParameters, cli, completeness
from rodwnl.balls import flint, working_bits
from rodwnl.completeness import _Piece, certify_complete, prove_complete, require_below
from rodwnl.errors import ComputationError
from rodwnl.halfplane import Value
from rodwnl.isolation import Box, steady_box, uniqueness_box
from rodwnl.spectrum import hopf_thresholds
from rodwnl.steady import steady_force

STIFF = RodParameters("1e4", "1e4", "1e-4")


def test_the_stiff_rod_has_one_threshold_up_to_forty():
    proved = prove_complete(hopf_thresholds(STIFF, 40))
    assert (proved.max_force, proved.crossings) == (40, 1)


def test_below_the_threshold_there_is_none():
    assert prove_complete(hopf_thresholds(STIFF, 20)).crossings == 0


def test_a_crossing_just_beyond_the_range_is_not_counted():
    """The search finds it in double precision; it lies 3.6e-17 above the last force, inside its own box."""
    rod, last = RodParameters(68000, 1150, "1.12e-4"), "36.378607630731426854286507086599953"
    with pytest.raises(ComputationError, match=r"near force 36\.37860763 lies at the end of the range"):
        prove_complete(hopf_thresholds(rod, last))


def test_neither_is_a_steady_crossing():
    near = hopf_thresholds(BUCKLES, 5).steady[0].force
    last = Fraction(mp.nstr(steady_force(BUCKLES, near, 40), 35))
    with working_bits(64):
        box = steady_box(BUCKLES, near)
        require_below(BUCKLES, box, last * (1 + Fraction("1e-25")))
        with pytest.raises(ComputationError, match="lies at the end of the range"):
            require_below(BUCKLES, box, last * (1 - Fraction("1e-25")))


def test_a_withheld_threshold_is_missed(monkeypatch):
    monkeypatch.setattr(completeness, "MOST_BOXES", 20_000)
    with working_bits(64), pytest.raises(ComputationError, match="no threshold near force"):
        certify_complete(STIFF, Fraction(38), [])


def test_another_threshold_does_not_stand_in_for_it(monkeypatch):
    monkeypatch.setattr(completeness, "MOST_BOXES", 20_000)
    rod = RodParameters(200, "1e4", "1e-4")
    upper = hopf_thresholds(rod)[1]
    with working_bits(64), pytest.raises(ComputationError, match="not proved"):
        certify_complete(rod, Fraction(51), [uniqueness_box(rod, upper.force, upper.omega).balls])


def test_a_range_up_to_k1_is_refused():
    with (
        working_bits(64),
        pytest.raises(ComputationError, match="that there is a straight rod up to the last force"),
    ):
        certify_complete(RodParameters(20, "1e4", "1e-4"), Fraction(20), [])


def test_the_command_states_it(capsys):
    rod = ["hopf", "--k1", "1e4", "--k2", "1e4", "--gamma3", "1e-4", "--max-force", "20"]
    assert cli.run([*rod, "--certified", "--complete", "--json"]) == 0
    assert json.loads(capsys.readouterr().out)["complete"]["crossings"] == 0
    assert cli.run([*rod, "--complete"]) == 2
    assert "belongs to --certified" in capsys.readouterr().err


def test_a_zero_is_not_excluded_by_slopes_of_another_branch(monkeypatch):
    """D = λ − i, at the centre of the box without a growth of e^{−5}: as such it would be far from 0."""

    def characteristic(rod, lam):
        D = lam - flint().acb(0, 1)
        if rod == "middle":
            return Value(D * flint().acb(5).exp(), flint().acb(-5), False)
        series = D if rod == "here" else flint().acb_series([D, 0])
        return Value(series, 0 * series, False)

    monkeypatch.setattr(completeness, "characteristic", characteristic)
    box = Box(flint().arb(1, "0.1"), flint().arb("1.05", "0.1"))
    with working_bits(64):
        assert completeness._excluded(_Piece(box, "here", "middle", "series")) == (False, False)
        clear = replace(box, omega=flint().arb("1.2", "0.1"))
        assert completeness._excluded(_Piece(clear, "here", "middle", "series"))[0]


BUCKLES = RodParameters("1e4", "1e2", "1e-2", model="partial_follower", chi="0.3")


def test_steady_crossings_are_counted():
    proved = prove_complete(hopf_thresholds(BUCKLES, 5))
    assert (proved.crossings, proved.steady) == (1, 1)


def test_a_withheld_steady_crossing_is_missed(monkeypatch):
    monkeypatch.setattr(completeness, "MOST_BOXES", 3_000)
    with working_bits(64), pytest.raises(ComputationError, match="no threshold near force"):
        certify_complete(BUCKLES, Fraction(5), [])


def test_a_touch_is_neither_counted_nor_left_out():
    rod = RodParameters("1e4", "1e4", "1e-4", model="partial_follower", chi="1/2")
    with pytest.raises(ComputationError, match=r"near force 9\.869604401 a real eigenvalue touches 0"):
        prove_complete(hopf_thresholds(rod, 12))


def test_a_rod_with_an_implicit_stretch():
    rod = RodParameters("1e4", "1e2", "1e-2", model="quartic")
    assert prove_complete(hopf_thresholds(rod, 10)).crossings == 0
