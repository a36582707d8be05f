"""Steady crossings in closed form, and what happens where two of them meet."""

import json
from decimal import Decimal

import mpmath as mp
import pytest

from rodwnl import RodParameters, cli
from rodwnl.errors import ComputationError
from rodwnl.spectrum import hopf_thresholds
from rodwnl.steady import extremum, steady_force
from rodwnl.straightrod import StraightRod

ROD = ["--k1", "200", "--k2", "1e4", "--gamma3", "1e-4", "--model", "partial-follower"]


def partial(chi, k1="1e4", k2="1e4"):
    return RodParameters(k1, k2, "1e-4", model="partial_follower", chi=chi)


@pytest.mark.parametrize("chi", ["0", "0.2", "0.45"])
@pytest.mark.parametrize("values", [("1e4", "1e4"), ("200", "100")])
def test_a_load_that_follows_in_part(chi, values):
    """cos p = −χ/(1 − χ), p² = F(ν + F/k2), to 40 digits."""
    rod = partial(chi, *values)
    found = steady_force(rod, hopf_thresholds(rod, 20).steady[0].force, 40)
    with mp.workdps(60):
        k1, k2 = map(mp.mpf, values)
        x = mp.mpf(chi)
        p, a = mp.acos(-x / (1 - x)), 1 / k2 - 1 / k1
        exact = 2 * p * p / (1 + mp.sqrt(1 + 4 * a * p * p))
        assert abs(found - exact) < mp.mpf(10) ** -40 * exact


def test_a_tip_moment_enters(monkeypatch):
    """Under a dead load, with the moment Θ(1)/2 at the tip: cos p = sin(p)/(2p)."""
    plain = StraightRod.__call__

    def with_moment(self, name, **fields):
        row = plain(self, name, **fields)
        return (row[0], row[1], mp.mpf(-1) / 2, row[3]) if name == "theta_tip_row" else row

    monkeypatch.setattr(StraightRod, "__call__", with_moment)
    with mp.workdps(40):
        force = steady_force(partial("0", "1e20", "1e20"), 1.3, 25)
        p = mp.sqrt(force)
        assert abs(mp.cos(p) - mp.sin(p) / (2 * p)) < mp.mpf(10) ** -18  # but for 1/k


@pytest.mark.parametrize(
    ("chi", "kind"),
    [("1/2", "touch"), ("0.49999999999999999999", "two crossings"), ("0.50000000000000000001", "none")],
)
def test_at_one_half_two_steady_crossings_merge(chi, kind):
    found = extremum(partial(chi), 9.8)
    assert found.kind == kind
    assert float(found.force) == pytest.approx(float(mp.pi) ** 2, rel=1e-14)


def test_the_search_goes_on_past_a_touch():
    at, beside = (hopf_thresholds(partial(chi), 60) for chi in ("1/2", "0.5000001"))
    assert at.touches == pytest.approx((float(mp.pi) ** 2,))
    assert (at.steady, beside.touches) == ((), ())
    assert len(at) == len(beside) == 1
    assert at[0].force == pytest.approx(beside[0].force, rel=1e-6)
    assert (at[0].unstable_below, at[0].unstable_above) == (0, 2)


def test_beside_one_half_there_are_two_or_none():
    assert len(hopf_thresholds(partial("0.49999999"), 15).steady) == 2
    assert hopf_thresholds(partial("0.5000000000001"), 15).steady == ()
    with pytest.raises(ComputationError, match=r"crosses 0 twice, 1\.1e-05 apart: too close for double"):
        hopf_thresholds(partial("0.4999999999999"), 15)


def test_a_touch_is_said(capsys):
    assert cli.run(["hopf", *ROD, "--parameter", "chi=1/2", "--max-force", "20"]) == 0
    assert "At force = 10.3995416913 a real eigenvalue touches 0 and turns back" in capsys.readouterr().out
    assert cli.run(["hopf", *ROD, "--parameter", "chi=1/2", "--max-force", "20", "--json"]) == 0
    assert float(json.loads(capsys.readouterr().out)["touches"][0]) == pytest.approx(10.3995416913)


def test_steady_crossings_have_digits_and_a_proof(capsys):
    line = ["landau", *ROD, "--parameter", "chi=0.3", "--max-force", "10"]
    assert cli.run([*line, "--digits", "30"]) == 0
    out = capsys.readouterr().out
    shown = dict(line.split() for line in out.splitlines()[-6:] if line)
    assert shown["force"] == "4.13895919318420563675668493177"
    assert shown["alpha"] == "-4.54653323836159739119350976679"
    assert cli.run(["hopf", *line[1:], "--digits", "30"]) == 0
    out = capsys.readouterr().out
    assert "The steady crossing to 30 digits: force = 4.13895919318420563675668493177." in out
    assert cli.run([*line, "--digits", "30", "--json"]) == 0
    (steady,) = json.loads(capsys.readouterr().out)["steady"]
    assert steady["force"] == "4.13895919318420563675668493177"
    pytest.importorskip("flint", reason="python-flint, the extra `certified`, is not installed")
    assert cli.run([*line, "--certified", "--digits", "25", "--json"]) == 0
    (steady,) = json.loads(capsys.readouterr().out)["steady"]
    for ball, widest in ((steady["force"], "1e-24"), (steady["unique_in"]["force"], "1")):
        off = abs(Decimal(ball["mid"]) - Decimal("4.13895919318420563675668493177"))
        assert off <= Decimal(ball["rad"]) < Decimal(widest)
