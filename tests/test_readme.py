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
    words, numbers = taken_apart(capsys.readouterr().out)
    expected_words, expected_numbers = taken_apart("\n".join(shown))
    assert words == expected_words
    assert numbers == pytest.approx(expected_numbers, rel=1e-9)


def taken_apart(text):
    """Words and numbers. The last digits of a number, and residuals altogether, are the machine's own."""
    words = [word.rstrip("i") for word in text.split() if not re.fullmatch(r"\d+e-1\d", word)]
    numbers = [word for word in words if re.fullmatch(r"-?\d+\.\d+", word)]
    return [word for word in words if word not in numbers], list(map(float, numbers))


@pytest.mark.parametrize("document", ["README.md", "CONTRIBUTING.md", "CONVENTIONS.md"])
def test_every_file_and_command_named_exists(document):
    text = (ROOT / document).read_text(encoding="utf-8")
    for path in re.findall(r"\]\(([^)]+)\)", text) + re.findall(r"`([\w./-]+/[\w./-]*)`", text):
        assert (ROOT / path).exists(), path
    assert set(re.findall(r"`rodwnl (\w+)", text)) <= set(cli.COMMANDS)
