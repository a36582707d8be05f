"""Figures: what they show is what was computed, and what stands on the disk is whole."""

import csv
import subprocess
import sys
import xml.etree.ElementTree as ElementTree
from dataclasses import replace

import numpy as np
import pytest

from rodwnl import drawings, figures
from rodwnl.animation import film
from rodwnl.branches import branch
from rodwnl.cli import run
from rodwnl.coefficients import landau
from rodwnl.errors import InputError
from rodwnl.figuredata import (
    Column,
    Comparison,
    SimulatedPoint,
    beating_like_the_papers,
    by_rod,
    columns_of,
    eigenvalue_path,
    paper_columns,
    simulated,
    theory,
)
from rodwnl.models import emitted
from rodwnl.parameters import RodParameters
from rodwnl.predictions import predict_at
from rodwnl.readout import Reading
from rodwnl.reduced import reduced_model
from rodwnl.simulation import simulate, to_dataset
from rodwnl.storage import load, save

FIRST = RodParameters("1e4", "1e4", "1e-4")


@pytest.fixture(scope="module")
def column():
    return Column(FIRST, landau(FIRST)[0])


@pytest.fixture(scope="module")
def beating():
    return simulate(FIRST, 42, "0.5", "0.2")


@pytest.fixture(scope="module")
def compared(column):
    """A comparison with a short branch, and one simulation in each state."""
    c = column.coefficients
    path = branch(FIRST, c.force, c.omega, window=(37.0, 38.0)).path
    followed = np.array([(o.force, o.tip_amplitude, o.omega, stable) for o, stable in path])
    readings = [
        Reading("settled", 0.1, 1e-6, 193.0, 1e-3, 0.0),
        Reading("not finished", 0.05, 1e-2, 192.0, 1.0, 0.5),
        Reading("decayed", 1e-8, 1e-8, None, None, -1.0),
    ]
    points = tuple(SimulatedPoint(37.5 + k, 0.01, reading) for k, reading in enumerate(readings))
    return Comparison(column, theory(column), points, followed, np.array([[38.0, 0.1, 193.0]]))


def test_the_papers_rods_and_thresholds_are_found():
    found = [(c.coefficients.force, c.coefficients.criticality, c.side) for c in paper_columns()]
    assert [round(force, 2) for force, *_ in found] == [37.66, 27.43, 49.76, 155.6]
    assert [side for *_, side in found] == [1, 1, 1, -1]
    assert [criticality for _, criticality, _ in found] == ["supercritical"] * 3 + ["subcritical"]


def test_an_eigenvalue_path_is_one_curve_through_the_threshold(column):
    c = column.coefficients
    path = eigenvalue_path(column, 25, 45, count=81)
    k = int(np.searchsorted(path.force, c.force))
    weight = (c.force - path.force[k - 1]) / (path.force[k] - path.force[k - 1])
    crossing = (1 - weight) * path.eigenvalue[k - 1] + weight * path.eigenvalue[k]
    assert crossing[0] == pytest.approx(1j * c.omega, rel=1e-4)
    np.testing.assert_allclose(path.eigenvalue[:, 0], path.eigenvalue[:, 1].conj(), rtol=1e-9)
    assert np.abs(np.diff(path.eigenvalue[:, 0])).max() < 4


def test_a_real_pair_below_the_meeting_point_is_followed(column):
    path = eigenvalue_path(column, 15, 40, count=151)
    assert np.abs(path.eigenvalue[0].imag).max() < 1e-6
    assert path.eigenvalue[0, 0] != pytest.approx(path.eigenvalue[0, 1])


def test_a_branch_is_drawn_through_its_points_and_around_its_fold():
    """F = 1 + s − s², A² = s, ω = 2 − s: a fold at s = 1/2, F = 5/4."""
    s = np.linspace(0, 1, 16)
    points = np.column_stack([1 + s - s**2, np.sqrt(s), 2 - s, s > 0.45])
    points = np.vstack([points, points[-1]])
    fine = drawings.smooth_branch(points)
    np.testing.assert_allclose(fine[:, 0], 1 + fine[:, 1] ** 2 - fine[:, 1] ** 4, atol=2e-3)
    np.testing.assert_allclose(fine[:, 2], 2 - fine[:, 1] ** 2, atol=2e-3)
    assert fine[:, 0].max() == pytest.approx(1.25, abs=2e-3)
    assert set(fine[fine[:, 1] ** 2 < 0.45, 3]) == {0}


def test_the_theory_drawn_is_the_prediction(column):
    drawn = theory(column)
    expected = predict_at(column.coefficients, drawn[30, 0])
    np.testing.assert_allclose(drawn[30, 1:], [expected.A_tip, expected.omega])
    assert drawn[0].tolist() == [column.coefficients.force, 0.0, column.coefficients.omega]


def test_simulations_are_repeated_until_they_settle(column, monkeypatch):
    monkeypatch.setattr("rodwnl.figuredata.PERIODS", 3)
    point = simulated(column, 42.0, 0.01)
    assert point.reading.state == "settled"
    assert point.reading.A_tip == pytest.approx(0.34970, abs=2e-4)


def read_table(path):
    with path.open(newline="", encoding="utf-8") as file:
        return list(csv.reader(file))


def test_each_figure_is_written_whole_with_caption_and_data(column, beating, compared, tmp_path):
    path = eigenvalue_path(column, 30, 45, count=16)
    model = reduced_model(FIRST, repr(column.coefficients.force), column.coefficients)
    made = [
        drawings.hopf([column, column], path),
        drawings.beta_check([column], [path]),
        drawings.nonlinear(beating),
        drawings.compared([compared]),
        drawings.modes([model]),
    ]
    for drawing in made:
        figures.write(drawing, tmp_path)
        header, *rows = read_table(tmp_path / f"{drawing.name}.csv")
        assert header == list(drawing.header)
        assert len(rows) == len(drawing.rows) > 3
        assert all(len(row) == len(header) for row in rows)
        assert (tmp_path / f"{drawing.name}.txt").read_text(encoding="utf-8") == drawing.caption + "\n"
        assert (tmp_path / f"{drawing.name}.png").read_bytes().startswith(b"\x89PNG")
        ElementTree.parse(tmp_path / f"{drawing.name}.svg")
    assert len(list(tmp_path.iterdir())) == 4 * len(made)
    first = (tmp_path / "comparison.svg").read_bytes()
    figures.write(drawings.compared([compared]), tmp_path)
    assert (tmp_path / "comparison.svg").read_bytes() == first


def test_the_comparison_shows_and_lists_what_was_computed(compared):
    drawing = drawings.compared([compared])
    series = {name: [row for row in drawing.rows if row[1] == name] for name in {r[1] for r in drawing.rows}}
    assert len(series["amplitude equation"]) == len(compared.theory)
    assert [row[2:5] for row in series["orbit"]] == compared.orbits[:, :3].tolist()
    assert [row[5] for row in series["simulation"]] == [
        "settled, from 0.01", "not finished, from 0.01", "decayed, from 0.01",
    ]  # fmt: skip
    top, bottom = drawing.figure.axes[:2]
    drawn = {tuple(xy) for line in top.lines for xy in line.get_xydata().tolist()}
    assert {(37.5, 0.1), (38.5, 0.05), (39.5, 0.0), (38.0, 0.1)} <= drawn
    frequencies = {tuple(xy) for line in bottom.lines for xy in line.get_xydata().tolist()}
    assert {(37.5, 193.0), (38.5, 192.0)} <= frequencies
    assert 39.5 not in {x for x, _ in frequencies}
    assert "F = 38" in drawing.caption


def test_the_comparison_has_a_key_to_what_it_shows(compared):
    (key,) = drawings.compared([compared]).figure.legends
    assert {text.get_text() for text in key.get_texts()} == {
        "amplitude equation", "periodic orbits", "fold", "threshold",
        "simulation", "simulation, not settled", "simulation, came to rest",
    }  # fmt: skip
    subcritical = replace(
        compared, orbits=np.column_stack([compared.orbits[:, :3], 0 * compared.orbits[:, 3]])
    )
    (key,) = drawings.compared([subcritical]).figure.legends
    assert "unstable" in {text.get_text() for text in key.get_texts()}


def test_a_run_is_plotted_from_its_file(beating, tmp_path, capsys):
    file = tmp_path / "run.nc"
    save(to_dataset(beating), file)
    assert run(["plot", str(file)]) == 0
    assert (tmp_path / "run.png").read_bytes().startswith(b"\x89PNG")
    assert "force = 42" in capsys.readouterr().out


def test_plot_refuses_what_it_cannot_draw(tmp_path, capsys):
    import xarray

    other = tmp_path / "other.nc"
    save(xarray.Dataset({"a": ("n", np.arange(3.0))}), other)
    refused = {
        ("plot", str(tmp_path / "none.nc")): "there is no file",
        ("plot", str(other)): "holds no simulation of a rod: time, tip_y",
        ("plot", str(other), "--out", str(tmp_path / "x.jpg")): "must end in .png, .svg, .pdf",
        ("plot", str(other), "--out", str(tmp_path / "no" / "x.png")): "does not exist",
    }
    for arguments, message in refused.items():
        assert run(list(arguments)) == 2
        error = capsys.readouterr().err
        assert message in error
        assert error.count("\n") == 1
    assert [p.name for p in tmp_path.iterdir()] == ["other.nc"]


def test_a_film_shows_the_last_beats(beating, tmp_path, monkeypatch):
    from PIL import Image

    monkeypatch.setattr("rodwnl.animation.SHOWN", 6)
    film(beating, tmp_path / "rod.gif")
    with Image.open(tmp_path / "rod.gif") as image:
        assert image.n_frames == 6
    assert [p.name for p in tmp_path.iterdir()] == ["rod.gif"]


def test_a_film_as_mp4_has_the_same_frames(beating, tmp_path, monkeypatch):
    from imageio_ffmpeg import get_ffmpeg_exe

    monkeypatch.setattr("rodwnl.animation.SHOWN", 6)
    film(beating, tmp_path / "rod.mp4")
    command = [get_ffmpeg_exe(), "-i", str(tmp_path / "rod.mp4"), "-f", "framehash", "-"]
    read = subprocess.run(command, capture_output=True, text=True, check=True)
    frames = [line.split(",")[-1] for line in read.stdout.splitlines() if not line.startswith("#")]
    assert len(frames) == len(set(frames)) == 6
    assert "Video: h264" in read.stderr
    assert [p.name for p in tmp_path.iterdir()] == ["rod.mp4"]


def test_a_film_of_another_kind_is_refused(beating, tmp_path, monkeypatch):
    with pytest.raises(InputError, match=r"must end in \.gif or \.mp4"):
        film(beating, tmp_path / "rod.avi")
    monkeypatch.setitem(sys.modules, "imageio_ffmpeg", None)
    with pytest.raises(InputError, match=r"pip install 'rodwnl\[film\]'"):
        film(beating, tmp_path / "rod.mp4")


def test_an_interrupted_figure_leaves_no_file(compared, tmp_path, monkeypatch):
    drawing = drawings.compared([compared])

    def interrupted(path, **options):
        if path.suffix == ".png":
            raise KeyboardInterrupt
        path.write_text("whole")

    monkeypatch.setattr(drawing.figure, "savefig", interrupted)
    with pytest.raises(KeyboardInterrupt):
        figures.write(drawing, tmp_path)
    assert list(tmp_path.iterdir()) == []


def test_the_command_writes_all_that_was_computed(compared, tmp_path, monkeypatch, capsys):
    monkeypatch.setattr(figures, "computed", lambda *given: iter([drawings.compared([compared])]))
    folder = tmp_path / "new"
    assert run(["figures", "--out", str(folder)]) == 0
    assert {p.suffix for p in folder.iterdir()} == {".svg", ".png", ".csv", ".txt"}
    assert "comparison.png" in capsys.readouterr().out
    blocked = tmp_path / "file"
    blocked.write_text("")
    assert run(["figures", "--out", str(blocked)]) == 2


SPRING = """
name = "springy"
title = "rod with a stiffening energy and a spring at the tip"
energy = "k1*(h1 - 1)^2/2 + k2*h2^2/2 + (exp(q*Pi^2) - 1)/(2*q)"

[parameters]
q = { default = "1/100", meaning = "stiffening in bending" }
kappa = { default = "1/5", meaning = "spring at the tip" }

[drag]
v1 = "gamma1"
v2 = "1"
Omega = "gamma3"

[[load]]
kind = "follower"
share = "1/2"

[[load]]
kind = "dead"
share = "1/2"

[[load]]
kind = "spring"
stiffness = "kappa"
"""


@pytest.fixture(scope="module")
def springy(tmp_path_factory):
    file = tmp_path_factory.mktemp("rod") / "rod.toml"
    file.write_text(SPRING, encoding="utf-8")
    return RodParameters("1e4", "1e4", "1e-4", model=emitted(str(file)))


def test_figures_of_another_rod(springy, tmp_path):
    """Its spectrum, modes and a run whose load keeps its direction in part; captions name the rod."""
    columns = columns_of([springy])
    (column,) = columns
    c = column.coefficients
    path = eigenvalue_path(column, *figures._range(columns), count=24)
    growth = np.interp(c.force, path.force, path.eigenvalue[:, 0].real)
    assert abs(growth) < 0.1 * np.abs(path.eigenvalue[:, 0].real).max()
    beats = simulate(springy, repr(1.5 * c.force), "0.3", "0.1", rtol=1e-6)
    along, across = beats.tip_load.T
    np.testing.assert_allclose(along, -(1 + np.cos(beats.theta[:, -1])) / 2, atol=1e-12)
    np.testing.assert_allclose(across, -np.sin(beats.theta[:, -1]) / 2, atol=1e-12)
    save(to_dataset(beats), tmp_path / "run.nc")
    with load(tmp_path / "run.nc") as kept:
        np.testing.assert_array_equal(kept["load_x"], along)
    caption = drawings.one_run(to_dataset(beats)).caption
    assert caption.startswith("model = springy, k1 = 10000, ")
    assert "q = 0.01, kappa = 0.2, force = " in caption
    found, _ = figures.orbits(column)
    assert found[0, 0] == pytest.approx(c.force)
    assert found[-1, 0] == pytest.approx(c.force * 1.12)
    comparison = Comparison(column, theory(column), (), found, np.empty((0, 3)))
    made = [
        drawings.hopf(columns, path),
        drawings.beta_check(columns, [path]),
        drawings.modes([reduced_model(springy, repr(c.force), c)]),
        drawings.compared([comparison]),
    ]
    for drawing in made:
        figures.write(drawing, tmp_path)
        if drawing.name != "comparison":
            assert "q = 0.01, kappa = 0.2 (springy)" in drawing.caption
    assert "unstable beyond the threshold" in made[0].caption


def test_which_run_is_drawn(springy):
    (start,) = beating_like_the_papers(columns_of([springy]))
    column, force, _ = start
    assert force == pytest.approx(1.06 * column.coefficients.force)
    reentrant = columns_of([RodParameters("149.5", "1e4", "1e-4")])
    assert [len(rod) for rod in by_rod([column, *reentrant])] == [1, 2]
    (start,) = beating_like_the_papers(reentrant)
    assert start[1] < reentrant[1].coefficients.force
    assert beating_like_the_papers(reentrant[1:]) == []


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["--model", "nosuch"], "there is no rod 'nosuch'"),
        (["--k1", "200"], "a rod for the figures also needs --k2 and --gamma3"),
        (["--parameter", "chi=1"], "name that one with --model"),
        (["--model", "metric-drag", "--k1", "2", "--k2", "2", "--gamma3", "1"], "no Hopf threshold"),
        (["--k1", "", "--k2", "2", "--gamma3", "1"], "k1 is '': not a finite number"),
    ],
)
def test_bad_rods_for_figures_end_with_one_line(tmp_path, capsys, arguments, message):
    assert run(["figures", "--out", str(tmp_path / "f"), *arguments]) == 2
    (line,) = capsys.readouterr().err.splitlines()
    assert message in line
    assert not (tmp_path / "f").exists()
