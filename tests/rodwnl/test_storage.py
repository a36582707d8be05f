"""Files that are put in place: links are followed, and nothing but a regular file is ever replaced."""

import os
import sys

import pytest

from rodwnl import cli
from rodwnl.errors import InputError
from rodwnl.storage import replacing, require_apart, require_writable


def write(path, text="new"):
    with replacing(path) as temporary:
        temporary.write_text(text)


def test_a_link_stays_one(tmp_path):
    target, link = tmp_path / "far" / "target", tmp_path / "link"
    target.parent.mkdir()
    target.write_text("old")
    link.symlink_to(target)
    write(link)
    assert link.is_symlink()
    assert target.read_text() == "new"
    assert [p.name for p in target.parent.iterdir()] == ["target"]


@pytest.mark.skipif(not hasattr(os, "mkfifo"), reason="there are no named pipes here")
def test_a_pipe_is_not_replaced(tmp_path):
    pipe = tmp_path / "pipe"
    os.mkfifo(pipe)
    for attempt in (write, require_writable):
        with pytest.raises(InputError, match="not a regular file"):
            attempt(pipe)
    assert pipe.is_fifo()
    assert cli.run(["verify", "--only", "eq:follower", "--html", str(pipe)]) == 2


def test_a_failure_leaves_the_old_file(tmp_path):
    def fails(path):
        with replacing(path) as temporary:
            temporary.write_text("half")
            raise RuntimeError

    path = tmp_path / "file"
    write(path, "old")
    with pytest.raises(RuntimeError):
        fails(path)
    assert path.read_text() == "old"
    assert os.listdir(tmp_path) == ["file"]


def test_a_ledger_page_that_cannot_be_written_is_refused_first(tmp_path, capsys):
    assert cli.run(["verify", "--html", str(tmp_path / "no" / "page.html")]) == 2
    said = capsys.readouterr()
    assert "does not exist" in said.err
    assert not said.out


def test_modules_of_others_are_not_overwritten(tmp_path, capsys):
    own = tmp_path / "__init__.py"
    own.write_text("x = 1\n")
    assert cli.run(["derive", "--model", "follower", "--out", str(tmp_path)]) == 2
    assert "__init__.py was not written by `rodwnl derive`" in capsys.readouterr().err
    assert own.read_text() == "x = 1\n"
    own.unlink()
    (tmp_path / "follower").mkdir()
    (tmp_path / "follower" / "mine.py").write_text("x = 1\n")
    assert cli.run(["derive", "--model", "follower", "--out", str(tmp_path)]) == 2
    assert "mine.py was not written" in capsys.readouterr().err


def test_a_closed_output_is_no_error(monkeypatch):
    monkeypatch.setattr(sys, "stdout", None)
    assert cli.run(["hopf", "--k1", "200", "--k2", "1e4", "--gamma3", "1e-4"]) == 0


ROD = ["--k1", "200", "--k2", "1e4", "--gamma3", "1e-4"]
MODEL = """
name = "mine"
title = "a rod from a file"
energy = "k1*(h1 - 1)^2/2 + k2*h2^2/2 + Pi^2/2"
drag = { v1 = "gamma1", v2 = "1", Omega = "gamma3" }
load = [{ kind = "follower" }]
"""


@pytest.mark.parametrize(
    ("name", "command"),
    [
        ("p.tex", ["verify", "--tex", "p.tex", "--html", "p.tex"]),
        ("letters.toml", ["verify", "--notation", "letters.toml", "--html", "link"]),
        ("rod.toml", ["verify", "--model", "rod.toml", "--html", "./rod.toml"]),
        ("rod.toml", ["export", "--format", "latex", "--model", "rod.toml", "rod.toml"]),
        ("rod.toml", ["export", "--format", "auto", "--model", "rod.toml", *ROD, "link"]),
        ("run.png", ["plot", "run.png"]),
        ("rod.gif", ["simulate", "--model", "./rod.gif", *ROD, "--force", "50", "--animate", "link"]),
        ("hopf.csv", ["figures", "--model", "./hopf.csv", "--out", "."]),
        ("summary.json", ["atlas", "--model", "./summary.json", "--out", ".", "--overwrite"]),
    ],
)
def test_no_command_writes_over_what_it_reads(name, command, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("RODWNL_CACHE", str(tmp_path / "cache"))
    content = MODEL if "--model" in command else r"\begin{equation} g_4 = 0 \end{equation}"
    (tmp_path / name).write_text(content)
    (tmp_path / "link").symlink_to(tmp_path / name)
    assert cli.run(command) == 2
    assert (
        f"this command reads {command[command.index('--model') + 1] if '--model' in command else name}"
        in (capsys.readouterr().err)
    )
    assert (tmp_path / name).read_text() == content


def test_a_rod_beside_the_figures_is_not_in_their_way(tmp_path):
    (tmp_path / "rod.toml").write_text(MODEL)
    require_apart(tmp_path, str(tmp_path / "rod.toml"), "follower", None)
    require_apart(tmp_path / "new.html", str(tmp_path / "rod.toml"))


def test_a_run_is_replaced_on_request_and_nothing_else_ever(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    run = ["simulate", *ROD, "--force", "20", "--time", "0.1", "--out"]
    assert cli.run([*run, "x.png"]) == 2
    assert "must end in .nc" in capsys.readouterr().err
    assert cli.run([*run, "run.nc"]) == 0
    first = (tmp_path / "run.nc").read_bytes()
    assert cli.run([*run, "run.nc"]) == 2
    assert "run.nc exists: give --overwrite to replace it" in capsys.readouterr().err
    assert (tmp_path / "run.nc").read_bytes() == first
    assert cli.run([*run, "run.nc", "--overwrite", "--perturbation", "2e-2"]) == 0
    assert (tmp_path / "run.nc").read_bytes() != first
    (tmp_path / "other.nc").write_text("precious")
    assert cli.run([*run, "other.nc", "--overwrite"]) == 2
    assert "it is not a run that simulate wrote" in capsys.readouterr().err
    assert (tmp_path / "other.nc").read_text() == "precious"
