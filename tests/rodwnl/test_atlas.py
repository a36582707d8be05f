import json

import numpy as np
import pytest

from rodwnl import RodParameters, atlas, cli, hopf_thresholds
from rodwnl.atlas import MAPS, Map, Witness, compute, count

pytest.importorskip("xarray")
pytest.importorskip("h5netcdf")
pytest.importorskip("matplotlib")

SMALL = Map("small", "k1", "k2", {"gamma3": 1e-4})


@pytest.fixture(scope="module")
def sheet(tmp_path_factory):
    """A coarse map with its special curves."""
    return compute(SMALL, tmp_path_factory.mktemp("atlas"), 24, 1)


def test_regions_are_those_of_single_rods(sheet):
    data = sheet.data
    for i, j in [(0, 20), (9, 20), (20, 20), (20, 2), (8, 12)]:
        here = data.isel(k1=i, k2=j)
        k1, k2 = float(here.k1), float(here.k2)
        expected = hopf_thresholds(RodParameters(k1, k2, 1e-4), min(k1, 400))
        near = here.force.values[: int(here["count"])]
        assert near[near <= 400] == pytest.approx([t.force for t in expected], rel=1e-8)


def test_counts_add_up(sheet):
    counts = count(sheet.data)
    assert counts["rods"] == 24 * 24 == sum(counts["regions"].values())
    assert counts["failed"] == 0
    assert sum(counts["thresholds"]["lower"].values()) == 24 * 24 - counts["regions"]["no flutter"]
    windows = counts["regions"]["reentrant window"] + counts["regions"]["window, and flutter again"]
    assert sum(counts["thresholds"]["upper"].values()) == windows


def test_special_curves_separate_what_they_should(sheet):
    """On both sides of the closing curve of the window: two thresholds, and none."""
    from rodwnl import landau_batch

    closings = [c for kind, c in sheet.curves if kind == "closing" and c.rods["k2"].max() > 1e5]
    assert closings
    curve = closings[0]
    at = int(np.argmin(np.abs(curve.rods["k2"] - 1e5)))
    k1, k2, gamma3, _ = (x[at] for x in curve.rods.values())
    assert landau_batch(k1 * np.array([1 - 1e-6, 1 + 1e-6]), k2, gamma3).count.tolist() == [0, 2]


def test_too_many_curves_of_one_kind_do_not_end_the_search_for_the_other(sheet, monkeypatch):
    rod = {"k1": 200.0, "k2": 1e4, "gamma3": 1e-4, "gamma1": 0.5}
    kinds = ("closing", "closing", "bautin")
    monkeypatch.setattr(atlas, "_changes", lambda *_: [(kind, rod, 50.0, 400.0) for kind in kinds])
    monkeypatch.setattr(atlas, "MOST_CURVES", 0)
    said = []
    assert list(atlas.special_curves(SMALL, sheet.data, said.append)) == []
    assert [line.split()[5] for line in said] == ["closing", "bautin"]


def test_a_witness_agrees_with_the_theory(monkeypatch):
    monkeypatch.setattr(atlas, "WITNESSES", atlas.WITNESSES[2:3])
    (witness,) = atlas.witnesses()
    assert isinstance(witness, Witness)
    assert (witness.criticality, witness.stable) == ("subcritical", False)
    assert witness.seen == pytest.approx(witness.predicted, rel=1e-4)


def test_command_writes_an_atlas(tmp_path, monkeypatch, capsys):
    monkeypatch.setattr(atlas, "MAPS", MAPS[:1])
    monkeypatch.setattr(atlas, "WITNESSES", ())
    out = tmp_path / "atlas"
    assert cli.run(["atlas", "--out", str(out), "--points", "12", "--workers", "1"]) == 0
    name = MAPS[0].name
    assert {p.name for p in out.iterdir()} == {f"{name}{s}" for s in (".nc", ".csv", ".svg", ".png")} | {
        "summary.json"
    }
    assert json.loads((out / "summary.json").read_text())["maps"][name]["rods"] == 144
    assert (out / f"{name}.csv").read_text().startswith("type,curve,k1,k2")
    assert cli.run(["atlas", "--out", str(out)]) == 2
    assert "is not empty: give --overwrite" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("arguments", "message"), [(["--points", "1"], "at least 2"), (["--workers", "0"], "--workers is 0")]
)
def test_bad_options(capsys, arguments, message):
    assert cli.run(["atlas", *arguments]) == 2
    assert message in capsys.readouterr().err


def test_a_file_in_the_way(tmp_path, capsys):
    (tmp_path / "atlas").write_text("x")
    assert cli.run(["atlas", "--out", str(tmp_path / "atlas")]) == 2
    assert "is not a folder" in capsys.readouterr().err
