import json
import os
import signal
import subprocess
import sys
import time
from functools import partial
from pathlib import Path

import numpy as np
import pytest

from rodwnl import RodParameters, cli, engines, landau
from rodwnl import sweep as sweeps
from rodwnl.errors import ComputationError, InputError
from rodwnl.grids import grid, read_grid

xr = pytest.importorskip("xarray")
pytest.importorskip("h5netcdf")

SMALL = {"k1": {"log": [150, 1e4], "points": 3}, "k2": {"values": [1e2, 1e4]}, "gamma3": 1e-4}


@pytest.fixture
def small(tmp_path):
    """A small grid in a file."""
    path = tmp_path / "small.toml"
    path.write_text("[k1]\nlog = [150, 1e4]\npoints = 3\n[k2]\nvalues = [1e2, 1e4]\n[gamma3]\nvalue = 1e-4\n")
    return path


@pytest.fixture
def blocks_of_two(monkeypatch):
    monkeypatch.setattr(sweeps, "BLOCK", 2)


def test_grid_has_one_dimension_per_parameter_with_several_values():
    g = grid(SMALL)
    assert (g.dims, g.shape, g.size) == (("k1", "k2"), (3, 2), 6)
    assert g.values["k1"].tolist()[::2] == [150, 1e4]
    assert g.values["k1"][1] == pytest.approx(np.sqrt(150 * 1e4))
    assert g.values["gamma1"] == 0.5


@pytest.mark.parametrize("most", [1, 2, 3, 4, 5, 6, 100])
def test_blocks_cover_the_grid_once(most):
    g = grid(SMALL | {"gamma1": {"linear": [0.1, 1], "points": 5}})
    seen = np.zeros(g.shape, dtype=int)
    for block in g.blocks(most):
        assert np.prod(block.shape) <= most
        seen[block.slices] += 1
        k1, k2, gamma3, gamma1 = g.rods(block).values()
        whole = np.meshgrid(g.values["k1"], g.values["k2"], g.values["gamma1"], indexing="ij")
        for part, values in zip((k1, k2, gamma1), whole, strict=True):
            np.testing.assert_array_equal(part, values[block.slices])
        assert np.all(gamma3 == 1e-4)
    assert np.all(seen == 1)


@pytest.mark.parametrize("method", ["sobol", "latin-hypercube"])
def test_sampling_fills_the_ranges_and_repeats(method):
    content = {
        "k1": {"log": [10, 1e5]}, "k2": {"linear": [1, 3]}, "gamma3": 1e-4,
        "sampling": {"method": method, "points": 300, "seed": 7},
    }  # fmt: skip
    g = grid(content)
    assert (g.dims, g.shape) == (("rod",), (300,))
    assert np.all((g.values["k1"] >= 10) & (g.values["k1"] <= 1e5))
    # evenly in log k1 and in k2: both samplings leave no tenth of a range short
    assert np.all(np.abs(np.histogram(np.log10(g.values["k1"]), 10, (1, 5))[0] - 30) <= 4)
    assert np.all(np.abs(np.histogram(g.values["k2"], 10, (1, 3))[0] - 30) <= 4)
    assert all(np.array_equal(g.values[n], grid(content).values[n]) for n in g.values)
    other = grid(content | {"sampling": {"method": method, "points": 300, "seed": 8}})
    assert not np.array_equal(g.values["k1"], other.values["k1"])


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"k3": 1}, "unknown key 'k3': did you mean k"),
        ({"gamma_3": 1}, "unknown key 'gamma_3': did you mean gamma3"),
        ({"k1": {"log": [1, 10], "point": 3}}, "unknown key of \\[k1\\] 'point': did you mean points"),
        ({"k1": {"values": []}}, "the grid has no points"),
        ({"k1": {"log": [1, 10], "points": 0}}, "points is 0, but it must be a whole number, 1 or more"),
        ({"k1": {"log": [1, 10], "points": 2.5}}, "points is 2.5"),
        ({"k1": {"log": [1, 10]}}, "also needs points"),
        ({"k1": {"log": [10, 1], "points": 3}}, "from < to"),
        ({"k1": {"log": [0, 1], "points": 3}}, "k1 is 0, but it must be greater than zero"),
        ({"k1": {"linear": [-1, 1], "points": 3}}, "k1 is -1"),
        ({"k1": {"log": [1, float("inf")], "points": 3}}, "k1 is inf: not a finite number"),
        ({"k1": {}}, "exactly one of value, values, log, linear, not none"),
        ({"k1": {"value": 1, "values": [1]}}, "not value and values"),
        ({"k1": {"value": 1, "points": 3}}, "points goes with log or linear"),
        ({"k1": {"values": 5}}, "must be a list"),
        ({"k1": {"values": [1, 1]}}, "twice"),
        ({"k1": {"values": ["a"]}}, "k1 is 'a'"),
        ({"max_force": 0}, "max_force is 0, but it must be greater"),
        ({"k1": {"linear": [1, 2], "points": 10**10}}, "the grid has 20000000000 rods"),
        ({"sampling": 4}, "sampling must be a table"),
        ({"sampling": {"method": "sobol"}}, "also needs points"),
        ({"sampling": {"method": "random", "points": 4}}, "there are latin-hypercube, sobol"),
        ({"sampling": {"method": "sobol", "points": 4}}, "points does not go with"),
    ],
)  # fmt: skip
def test_bad_grids_are_refused(change, message):
    with pytest.raises(InputError, match=message):
        grid(SMALL | change)


def test_missing_parameters_are_named():
    with pytest.raises(InputError, match="there is no k2 and no gamma3"):
        grid({"k1": 1})


@pytest.mark.parametrize("suffix", [".nc", ".zarr"])
def test_file_is_described_and_right(tmp_path, small, blocks_of_two, suffix):
    if suffix == ".zarr":
        pytest.importorskip("zarr")
    out = tmp_path / f"atlas{suffix}"
    reports = []
    sweeps.sweep(read_grid(small), out, workers=1, progress=lambda *r: reports.append(r))
    assert reports[0] == (0, 6)
    assert reports[-1] == (6, 6)
    assert not out.with_name(out.name + ".parts").exists()
    engine = "h5netcdf" if suffix == ".nc" else "zarr"
    with xr.open_dataset(out, engine=engine) as data:
        assert dict(data.sizes) == {"k1": 3, "k2": 2, "threshold": 4}
        assert all(
            {"long_name", "units"} <= set(data[name].attrs)
            for name in (*sweeps.VARIABLES, *sweeps.PARAMETERS)
        )
        assert {"program", "rod", "emitted_code", "accuracy", "grid"} <= set(data.attrs)
        assert data.status.dtype == np.int8
        for k1 in data.k1.values.tolist():
            for k2 in data.k2.values.tolist():
                here = data.sel(k1=k1, k2=k2)
                expected = landau(RodParameters(k1, k2, 1e-4))
                assert int(here["count"]) == len(expected)
                for i, c in enumerate(expected):
                    at = here.isel(threshold=i)
                    assert float(at.force) == pytest.approx(c.force, rel=1e-9)
                    assert complex(at.alpha_re, at.alpha_im) == pytest.approx(c.alpha, rel=1e-9)
                    assert complex(at.beta_re, at.beta_im) == pytest.approx(c.beta, rel=1e-9)
                assert np.all(np.isnan(here.force[len(expected) :]))


def test_sampling_in_a_file(tmp_path):
    g = grid(
        {"k1": {"log": [150, 1e4]}, "k2": 1e4, "gamma3": 1e-4, "sampling": {"method": "sobol", "points": 3}}
    )
    sweeps.sweep(g, tmp_path / "s.nc", workers=1)
    with xr.open_dataset(tmp_path / "s.nc", engine="h5netcdf") as data:
        np.testing.assert_array_equal(data.k1, g.values["k1"])
        assert data.k1.dims == ("rod",)
        assert {"k1", "k2", "gamma3", "gamma1"} <= set(data.coords)


def test_failures_are_written_with_their_reasons(tmp_path, monkeypatch):
    g = grid({"k1": {"values": [1e4, 1e5]}, "k2": 1e4, "gamma3": 1e-4})
    real = engines.landau_batch

    def failing(k1, **others):
        return real(k1 * [np.nan, 1], **others)

    monkeypatch.setattr(engines, "landau_batch", failing)
    monkeypatch.setattr(
        sweeps, "on_this_machine", lambda tasks, _: ((t[0], engines.compute(*t[1:])) for t in tasks)
    )
    sweeps.sweep(g, tmp_path / "f.nc")
    with xr.open_dataset(tmp_path / "f.nc", engine="h5netcdf") as data:
        assert data.status.values.tolist() == [3, 0]
        (rod,) = json.loads(data.attrs["failures"])
        assert rod.startswith("k1 = 10000, k2 = 10000")


def test_resume_computes_only_what_is_missing(tmp_path, small, blocks_of_two, monkeypatch):
    numbers, out = [], tmp_path / "out.nc"

    def here(tasks, _, most):
        for number, *arguments in list(tasks)[:most]:
            numbers.append(number)
            yield number, engines.compute(*arguments)
        if most == 1:
            raise KeyboardInterrupt

    monkeypatch.setattr(sweeps, "on_this_machine", lambda tasks, workers: here(tasks, workers, 1))
    with pytest.raises(KeyboardInterrupt):
        sweeps.sweep(read_grid(small), out)
    monkeypatch.setattr(sweeps, "on_this_machine", lambda tasks, workers: here(tasks, workers, 9))
    reports = []
    sweeps.sweep(read_grid(small), out, resume=True, progress=lambda *r: reports.append(r))
    assert numbers == [0, 1, 2]
    assert reports[0] == (2, 6)


def test_blocks_whose_plan_is_gone_are_not_taken(tmp_path, small, blocks_of_two, monkeypatch):
    """They may be another grid's: a run killed while it removed its folder leaves such ones."""
    g, out, numbers = read_grid(small), tmp_path / "out.nc", []
    plan = sweeps.prepare(g, out, resume=False, overwrite=False)
    plan.part(1).write_bytes(b"of another grid")
    (plan.parts / "plan.json").unlink()

    def here(tasks, _):
        for number, *arguments in tasks:
            numbers.append(number)
            yield number, engines.compute(*arguments)

    monkeypatch.setattr(sweeps, "on_this_machine", here)
    sweeps.sweep(g, out)
    assert numbers == [0, 1, 2]


@pytest.mark.parametrize("suffix", [".nc", ".zarr"])
def test_a_removal_that_is_cut_off_leaves_nothing_that_looks_whole(tmp_path, small, monkeypatch, suffix):
    g, out = read_grid(small), tmp_path / f"out{suffix}"
    again = partial(sweeps.prepare, g, out, resume=False)
    old = out if suffix == ".zarr" else again(overwrite=False).parts
    if suffix == ".zarr":
        pytest.importorskip("zarr").open_group(out, mode="w").attrs.update(program="rodwnl", grid="")
    rmtree, calls = sweeps.shutil.rmtree, []

    def cut_off(path):
        calls.append(path)
        if len(calls) == 1:
            raise KeyboardInterrupt
        rmtree(path)

    monkeypatch.setattr(sweeps.shutil, "rmtree", cut_off)
    with pytest.raises(KeyboardInterrupt):
        again(overwrite=True)
    assert not old.exists()
    again(overwrite=False)  # as if there had been nothing
    again(overwrite=True)
    assert not calls[0].exists()


def run(*arguments):
    """A sweep in a process of its own."""
    command = [sys.executable, "-m", "rodwnl", "sweep", *map(str, arguments)]
    return subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)


def medium(tmp_path):
    """A grid in three blocks, so that a run can be caught between them."""
    path = tmp_path / "medium.toml"
    path.write_text(
        "k2 = 1e4\n[k1]\nlog = [150, 1e4]\npoints = 600\n[gamma3]\nlog = [1e-5, 1e-2]\npoints = 30\n"
    )
    return path


def wait_for_a_block(process, out):
    """Wait until a block is done, with the run still going."""
    deadline = time.monotonic() + 60
    while not list(out.with_name(out.name + ".parts").glob("[0-9]*.npz")):
        assert time.monotonic() < deadline
        time.sleep(0.005)
    assert process.poll() is None


def test_killed_and_resumed_is_bit_identical(tmp_path):
    toml, whole, killed = medium(tmp_path), tmp_path / "whole.nc", tmp_path / "killed.nc"
    with run(toml, "--out", whole, "--workers", 1) as process:
        assert process.wait(120) == 0
    with run(toml, "--out", killed, "--workers", 1) as process:
        wait_for_a_block(process, killed)
        process.kill()
    assert not killed.exists()
    parts = killed.with_name("killed.nc.parts")
    assert 0 < len(list(parts.glob("[0-9]*.npz"))) < 3
    with run(toml, "--out", killed, "--resume", "--workers", 2) as process:
        assert process.wait(120) == 0
    assert not parts.exists()
    assert killed.read_bytes() == whole.read_bytes()


def test_killed_worker_is_replaced(tmp_path):
    toml, out = medium(tmp_path), tmp_path / "out.nc"
    with run(toml, "--out", out, "--workers", 1) as process:
        wait_for_a_block(process, out)
        children = Path(f"/proc/{process.pid}/task/{process.pid}/children").read_text().split()
        workers = [int(p) for p in children if b"spawn_main" in Path(f"/proc/{p}/cmdline").read_bytes()]
        assert workers
        for worker in workers:
            os.kill(worker, signal.SIGKILL)
        assert process.wait(120) == 0
    with xr.open_dataset(out, engine="h5netcdf") as data:
        assert np.all(data.status <= 2)


def test_workers_that_keep_dying_end_the_sweep(tmp_path, small, monkeypatch):
    monkeypatch.setattr(engines, "compute", _die)
    with pytest.raises(ComputationError, match="died 4 times in a row"):
        sweeps.sweep(read_grid(small), tmp_path / "x.nc", workers=1)


def _die(*_):
    os._exit(9)


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["--out", "x.txt"], "must end in .nc"),
        (["--out", "missing/x.nc"], "the folder missing does not exist"),
        (["--workers", "0"], "--workers is '0'"),
        (["--workers", "two"], "--workers is 'two'"),
        (["--resume", "--overwrite"], "give one of them"),
        (["--workers", "1", "--scheduler", "tcp://127.0.0.1:1"], "give one of them"),
    ],
)
def test_bad_options(small, monkeypatch, capsys, arguments, message):
    monkeypatch.chdir(small.parent)
    assert cli.run(["sweep", str(small), *arguments]) == 2
    assert message in capsys.readouterr().err
    assert sorted(p.name for p in small.parent.iterdir()) == ["small.toml"]


def test_bad_grid_files(tmp_path, capsys):
    assert cli.run(["sweep", str(tmp_path / "none.toml")]) == 2
    assert "No such file" in capsys.readouterr().err
    (tmp_path / "bad.toml").write_text("k1 = = 3")
    assert cli.run(["sweep", str(tmp_path / "bad.toml")]) == 2
    assert "is not TOML" in capsys.readouterr().err


def test_scheduler_that_does_not_answer(small, monkeypatch, capsys):
    pytest.importorskip("distributed")
    monkeypatch.setattr(engines, "SCHEDULER_TIMEOUT", 0.2)
    assert cli.run(["sweep", str(small), "--scheduler", "tcp://127.0.0.1:1"]) == 2
    assert "the scheduler tcp://127.0.0.1:1 does not answer" in capsys.readouterr().err
    assert [path.name for path in small.parent.iterdir()] == ["small.toml"]


@pytest.mark.parametrize("place", ["mine.zarr/x", "mine.nc/x", "mine.nc.parts/x", "mine.nc"])
def test_nothing_is_removed_that_no_sweep_wrote(place, small, capsys):
    file = small.parent / place
    file.parent.mkdir(exist_ok=True)
    file.write_text("precious")
    out = small.parent / place.split("/")[0].removesuffix(".parts")
    for option in ([], ["--overwrite"], ["--resume"]):
        assert cli.run(["sweep", str(small), "--out", str(out), "--workers", "1", *option]) == 2
        assert place.split("/")[0] in capsys.readouterr().err
        assert file.read_text() == "precious"


def test_existing_output(small, capsys, blocks_of_two):
    out = small.with_suffix(".nc")
    assert cli.run(["sweep", str(small), "--workers", "1"]) == 0
    first = out.read_bytes()
    assert cli.run(["sweep", str(small)]) == 2
    assert "give --resume to go on with it or --overwrite" in capsys.readouterr().err
    assert cli.run(["sweep", str(small), "--resume"]) == 0  # nothing left to do
    assert out.read_bytes() == first
    small.write_text(small.read_text().replace("150", "151"))
    assert cli.run(["sweep", str(small), "--resume"]) == 2
    assert "cannot be resumed: its grid differs" in capsys.readouterr().err
    assert out.read_bytes() == first
    assert cli.run(["sweep", str(small), "--overwrite", "--workers", "1"]) == 0
    assert out.read_bytes() != first


def test_resume_of_another_version_or_of_something_else(small, monkeypatch, capsys):
    out = small.with_suffix(".nc")
    sweeps.sweep(read_grid(small), out, workers=1)
    monkeypatch.setattr(sweeps, "__version__", "99")
    assert cli.run(["sweep", str(small), "--resume"]) == 2
    assert "its program differs, there rodwnl 0" in capsys.readouterr().err
    out.write_text("not a netCDF file")
    assert cli.run(["sweep", str(small), "--resume"]) == 2
    assert "it was not written by rodwnl sweep, or it is damaged" in capsys.readouterr().err


def test_same_numbers_through_dask(small, tmp_path):
    distributed = pytest.importorskip("distributed")
    here, there = tmp_path / "here.nc", tmp_path / "there.nc"
    sweeps.sweep(read_grid(small), here, workers=1)
    with distributed.LocalCluster(
        n_workers=1, threads_per_worker=1, processes=False, dashboard_address=None, protocol="tcp://"
    ) as cluster:
        sweeps.sweep(read_grid(small), there, scheduler=cluster.scheduler_address)
    assert here.read_bytes() == there.read_bytes()
