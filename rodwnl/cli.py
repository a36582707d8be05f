"""The command line: which commands there are, and how each of them ends.

A command is a module of `rodwnl.commands` with one function `command`; its docstring is the help text, what
it returns is the exit code (None is 0). These modules import numerics inside the function, so that `--help`
and every command pay only for what they use.
"""

import io
import os
import sys
from collections.abc import Sequence
from importlib import import_module
from typing import Annotated, Any

import typer
from typer.core import TyperGroup

from rodwnl.errors import ComputationError, InputError, shown

COMMANDS = (  # as --help lists them
    "hopf", "landau", "predict", "orbit", "branch", "hysteresis", "simulate", "plot", "figures",
    "sweep", "curve", "atlas", "explore", "reproduce", "derive", "verify", "export"
)  # fmt: skip


class LazyCommands(TyperGroup):
    """The commands by name, each imported when it is asked for."""

    def list_commands(self, ctx: Any) -> list[str]:
        return list(COMMANDS)

    def get_command(self, ctx: Any, cmd_name: str) -> Any:
        if cmd_name not in COMMANDS:
            raise InputError(f"there is no command {cmd_name!r}; there are {', '.join(COMMANDS)}")
        command = typer.Typer(add_completion=False)
        command.command(cmd_name)(import_module(f"rodwnl.commands.{cmd_name}").command)
        return typer.main.get_command(command)

    def resolve_command(self, ctx: Any, args: list[str]) -> Any:
        name, command, rest = super().resolve_command(ctx, args)
        _require_once(command, rest)
        return name, command, rest


def _require_once(command: Any, arguments: Sequence[str]) -> None:
    """An option that takes one value is given once: of two values one would be lost without a word."""
    given = [text.partition("=")[0] for text in arguments]
    for option in command.params:
        for name in option.opts:
            if name.startswith("-") and not (option.multiple or option.is_flag) and given.count(name) > 1:
                raise InputError(f"{name} is given {given.count(name)} times, but it takes one value")


app = typer.Typer(cls=LazyCommands, add_completion=False, invoke_without_command=True)


@app.callback()
def rodwnl(
    ctx: typer.Context, version: Annotated[bool, typer.Option("--version", help="Print the version.")] = False
) -> None:
    """Flutter of a rod under a follower force, near its onset: thresholds, Landau coefficients, predictions.

    All numbers are dimensionless (lengths in L, times in γ₂L⁴/k₃, forces in k₃/L²) unless a rod is given in
    SI units through --length, --k3 and --gamma2.
    """
    if version:
        from rodwnl import __version__

        print(f"rodwnl {__version__}")
    elif ctx.invoked_subcommand is None:
        print(ctx.get_help())


def run(arguments: Sequence[str]) -> int:
    """Run one command line and return its exit code.

    0: done; 1: done, and what was compared differs; 2: bad input or nothing could be computed, one line on
    stderr says why; 130: interrupted; 141: the reader of the output went away.
    """
    # Before NumPy is imported: the matrices are small, and a second BLAS thread costs more than it gives.
    for variable in ("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS", "MKL_NUM_THREADS"):
        os.environ.setdefault(variable, "1")
    # Python has no stream where the shell closed it; what is printed there is lost, and nothing else.
    sys.stdout, sys.stderr = (stream or io.StringIO() for stream in (sys.stdout, sys.stderr))
    if isinstance(sys.stdout, io.TextIOWrapper):
        sys.stdout.reconfigure(errors="replace")  # a Greek letter must not fail where only ASCII can be shown
    commands = typer.main.get_command(app)
    try:
        with commands.make_context("rodwnl", list(arguments)) as context:
            code = commands.invoke(context)
        sys.stdout.flush()
        return code or 0
    except typer.Exit as done:
        return done.exit_code
    except (InputError, ComputationError) as error:
        return _fail(str(error))
    except typer.TyperException as error:
        return _fail(f"{error.format_message().rstrip('.')} (--help lists the options)")
    except BrokenPipeError:
        # Python flushes stdout once more on exit; give it a place where that cannot fail.
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return 141
    except OSError as error:
        return _fail(": ".join(str(part) for part in (error.filename, error.strerror or error) if part))
    except KeyboardInterrupt:
        return 130


def _fail(message: str) -> int:
    print(f"rodwnl: {shown(' '.join(message.split()))}", file=sys.stderr)
    return 2
