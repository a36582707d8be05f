import os
import subprocess
import sys
from types import SimpleNamespace

import pytest

from rodwnl import cli
from rodwnl.errors import ComputationError, InputError
from rodwnl.options import MaxForce, read_force, takes_rod


def process(*arguments, code="from rodwnl.__main__ import main; main()"):
    return subprocess.run([sys.executable, "-c", code, *arguments], capture_output=True, text=True)


@pytest.fixture
def toy(monkeypatch):
    """Put a function in the place of the command `hopf`."""

    def install(function):
        monkeypatch.setitem(sys.modules, "rodwnl.commands.hopf", SimpleNamespace(command=function))

    return install


@pytest.fixture
def echo(toy):
    """A command that records the rod it is given."""
    rods = []

    @takes_rod
    def command(rod, max_force: MaxForce = None):
        """Echo."""
        rods.append((rod, max_force))

    toy(command)
    return rods


ROD = ["--k1", "200", "--k2", "1e4", "--gamma3", "1e-4"]


def test_every_command_is_listed_with_its_first_line(capsys):
    assert cli.run(["--help"]) == 0
    listed = capsys.readouterr().out
    assert all(f" {name} " in listed for name in cli.COMMANDS)
    assert cli.run([]) == 0
    assert capsys.readouterr().out == listed


def test_help_imports_no_numerics():
    code = (
        "import sys; from rodwnl.cli import run; run(['--help']);"
        "print([m for m in ('numpy', 'scipy', 'sympy', 'matplotlib') if m in sys.modules])"
    )
    assert process(code=code).stdout.splitlines()[-1] == "[]"


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["flutter"], "no command 'flutter'; there are hopf, landau"),
        (["hopf", "--k2", "1", "--gamma3", "1"], "Missing option '--k1'"),
        (["hopf", *ROD, "--k4", "1"], "No such option: --k4"),
        (["hopf", *ROD, "--gamma1"], "'--gamma1' requires an argument"),
        (["hopf", *ROD, "--k1=300"], "--k1 is given 2 times, but it takes one value"),
        (["hopf", *ROD, "--gamma1", "0." + 100_000 * "0"], "it has 100002 characters, more than 1000"),
        (["hopf", *ROD, "surplus"], "surplus"),
        (["hopf", "--k1", "0", *ROD[2:]], "k1 is '0', but it must be greater than zero"),
        (["hopf", *ROD[:4], "--gamma3", "nan"], "gamma3 is 'nan': not a finite number"),
        (["hopf", *ROD, "--gamma1", "-0.5"], "gamma1 is '-0.5', but it must be greater than zero"),
        (["hopf", *ROD, "--length", "0.1"], "also needs --k3 and --gamma2"),
        (["hopf", *ROD, "--length", "0", "--k3", "1", "--gamma2", "1"], "L is '0'"),
    ],
)
def test_bad_input_is_one_line_and_exit_code_2(echo, capsys, arguments, message):
    assert cli.run(arguments) == 2
    out, err = capsys.readouterr()
    assert out == ""
    assert message in err
    assert err.startswith("rodwnl: ")
    assert err.count("\n") == 1
    assert echo == []


def test_a_rod_is_read_exactly(echo):
    assert cli.run(["hopf", *ROD, "--gamma1", "1/3", "--max-force", "-1"]) == 0
    ((rod, max_force),) = echo
    assert rod.texts() == {"k1": "200", "k2": "10000", "gamma3": "0.0001", "gamma1": "1/3"}
    assert max_force == "-1"


def test_a_rod_in_si_units(echo):
    si = ["--length", "0.1", "--k3", "2e-4", "--gamma2", "0.5"]
    assert cli.run(["hopf", "--k1", "10", "--k2", "20", "--gamma3", "1e-6", *si]) == 0
    ((rod, _),) = echo
    assert rod.texts() == {"k1": "500", "k2": "1000", "gamma3": "0.0002", "gamma1": "0.5"}
    assert read_force(rod, "force", "0.02") == 1


@pytest.mark.parametrize(
    ("error", "line"),
    [
        (InputError("a\nb"), "rodwnl: a b\n"),
        (ComputationError("no convergence"), "rodwnl: no convergence\n"),
        (PermissionError(13, "Permission denied", "/x"), "rodwnl: /x: Permission denied\n"),
        (OSError(28, "No space left on device"), "rodwnl: No space left on device\n"),
    ],
)
def test_failures_are_one_line_and_exit_code_2(toy, capsys, error, line):
    def command():
        raise error

    toy(command)
    assert cli.run(["hopf"]) == 2
    assert capsys.readouterr() == ("", line)


def test_a_bug_is_not_hidden(toy):
    def command():
        raise ZeroDivisionError

    toy(command)
    with pytest.raises(ZeroDivisionError):
        cli.run(["hopf"])


def test_a_command_returns_its_exit_code(toy):
    toy(lambda: 1)
    assert cli.run(["hopf"]) == 1


def test_an_interrupt_is_quiet(toy, capsys):
    def command():
        raise KeyboardInterrupt

    toy(command)
    assert cli.run(["hopf"]) == 130
    assert capsys.readouterr().err == ""


def test_a_reader_that_goes_away_is_no_error():
    code = (
        "import sys; from types import SimpleNamespace; from rodwnl.cli import run;"
        "many = lambda: [print('x' * 1000) for _ in range(1000)] and None;"
        "sys.modules['rodwnl.commands.hopf'] = SimpleNamespace(command=many);"
        "sys.exit(run(['hopf']))"
    )
    writer = subprocess.Popen([sys.executable, "-c", code], stdout=subprocess.PIPE, stderr=subprocess.PIPE)
    writer.stdout.readline()
    writer.stdout.close()
    with writer.stderr:
        assert (writer.wait(), writer.stderr.read()) == (141, b"")


def test_version():
    import rodwnl

    result = process("--version")
    assert (result.returncode, result.stdout) == (0, f"rodwnl {rodwnl.__version__}\n")
    result = subprocess.run([sys.executable, "-m", "rodwnl", "--version"], capture_output=True, text=True)
    assert result.stdout == f"rodwnl {rodwnl.__version__}\n"


def test_an_output_that_knows_only_ascii():
    result = subprocess.run(
        [sys.executable, "-m", "rodwnl", "landau", "--help"],
        capture_output=True,
        env=os.environ | {"PYTHONIOENCODING": "ascii"},
    )
    assert (result.returncode, result.stderr) == (0, b"")
    assert b"|A|?" in result.stdout
