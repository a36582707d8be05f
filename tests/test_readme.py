"""The README tells the truth: its code runs, its output is what the command prints, its files exist."""

import re
import textwrap
from pathlib import Path

import pytest

from rodwnl import cli

ROOT = Path(__file__).resolve().parent.parent
README = (ROOT / "README.md").read_text(encoding="utf-8")
BLOCKS = [textwrap.dedent(block) for block in re.findall(r"(?:^(?: {4}.*)?\n)+", README, re.MULTILINE)]


def block_with(start):
    (block,) = (b.strip("\n") for b in BLOCKS if b.strip("\n").startswith(start))
    return block


def test_the_example_runs(capsys):
    exec(compile(block_with("from rodwnl import"), "README.md", "exec"), {})
    assert len(capsys.readouterr().out.splitlines()) == 6


def test_the_output_shown_is_the_output(capsys):
    command, *shown = block_with("$ rodwnl landau").splitlines()
    assert cli.run(command.split()[2:]) == 0
    printed = capsys.readouterr().out
    expected = list(map(value, "\n".join(shown).split()))
    assert list(map(value, printed.split())) == pytest.approx(expected, rel=1e-9)


def value(word):
    """A number as a float: its last digits, and residuals altogether, are the machine's own."""
    if re.fullmatch(r"\d+e-1\d", word):
        return "a residual"
    return float(word.rstrip("i")) if re.fullmatch(r"-?\d+\.\d+i?", word) else word


@pytest.mark.parametrize("document", ["README.md", "CONTRIBUTING.md", "CONVENTIONS.md"])
def test_every_file_and_command_named_exists(document):
    text = (ROOT / document).read_text(encoding="utf-8")
    for path in re.findall(r"\]\(([^)]+)\)", text) + re.findall(r"`([\w./-]+/[\w./-]*)`", text):
        assert (ROOT / path).exists(), path
    assert set(re.findall(r"`rodwnl (\w+)", text)) <= set(cli.COMMANDS)
