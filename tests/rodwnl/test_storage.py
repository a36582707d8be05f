"""Files that are put in place: links are followed, and nothing but a regular file is ever replaced."""

import os
import sys

import pytest

from rodwnl import cli
from rodwnl.errors import InputError
from rodwnl.storage import replacing, require_writable


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
