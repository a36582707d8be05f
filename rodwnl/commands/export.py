"""`rodwnl export`: the derived equations and functions for the other tools of the field."""

import sys
from pathlib import Path
from typing import Annotated, Any

import typer

from rodwnl.errors import InputError

AUTO = "auto"  # the one format that needs numbers: continuation starts from a solution
FORMATS = ("latex", "mathematica", "julia", "c", "jax", AUTO)

_NUMBERS = "With --format auto: "


def command(
    file: Annotated[str, typer.Argument(metavar="FILE", help="File to write; - is standard output.")],
    form: Annotated[str, typer.Option("--format", metavar="NAME", help=f"One of {', '.join(FORMATS)}.")],
    model: Annotated[
        str | None, typer.Option(metavar="NAME|FILE", help="A shipped rod, or a rod.toml. Default: follower.")
    ] = None,
    k1: Annotated[str | None, typer.Option(metavar="X", help=f"{_NUMBERS}stretch stiffness.")] = None,
    k2: Annotated[str | None, typer.Option(metavar="X", help=f"{_NUMBERS}shear stiffness.")] = None,
    gamma3: Annotated[str | None, typer.Option(metavar="X", help=f"{_NUMBERS}rotational drag.")] = None,
    gamma1: Annotated[str | None, typer.Option(metavar="X", help=f"{_NUMBERS}axial drag.")] = None,
    parameter: Annotated[
        list[str] | None, typer.Option(metavar="NAME=X", help=f"{_NUMBERS}a parameter of the model's own.")
    ] = None,
    threshold: Annotated[
        int | None, typer.Option(metavar="N", help=f"{_NUMBERS}which threshold, by force. Default: 1.")
    ] = None,
) -> None:
    """Write what was derived in the language of another tool.

    latex: the equations. mathematica, julia, c, jax: all emitted functions. auto: the critical mode as a
    boundary-value problem for AUTO-07p, with a solution to start from.
    """
    from rodwnl.storage import require_apart, require_writable

    if form not in FORMATS:
        raise InputError(f"there is no format {form!r}; there are {', '.join(FORMATS)}")
    if file != "-":
        require_apart(Path(file), model)
        require_writable(Path(file))
    numbers: dict[str, Any] = {"k1": k1, "k2": k2, "gamma3": gamma3, "gamma1": gamma1, "parameter": parameter}
    if form == AUTO:
        text = _auto(model, numbers, 1 if threshold is None else threshold)
    else:
        numbers |= {"threshold": threshold}
        if given := [name for name, value in numbers.items() if value not in (None, [])]:
            raise InputError(f"--format {form} holds no numbers: leave out --{', --'.join(given)}")
        text = _symbolic(model, form)
    if file == "-":
        print(text, end="")
    else:
        _write(Path(file), text)


def _symbolic(model: str | None, form: str) -> str:
    from derivation.export import FORMATS
    from rodwnl.models import refusals

    derived = _derivation(model)
    with refusals(derived.model.name):
        return FORMATS[form](derived)


def _auto(model: str | None, numbers: dict[str, Any], threshold: int) -> str:
    from derivation.export import auto_equations
    from rodwnl.models import refusals
    from rodwnl.options import read_rod
    from rodwnl.starts import mode_start

    if missing := [f"--{name}" for name in ("k1", "k2", "gamma3") if numbers[name] is None]:
        raise InputError(f"--format {AUTO} starts from the mode of one rod: give {', '.join(missing)} too")
    values = numbers | {"model": model, "length": None, "k3": None, "gamma2": None}
    start = mode_start(read_rod(values), threshold)
    derived = _derivation(model)
    with refusals(derived.model.name):
        return auto_equations(derived, start.title, start.parameters, start.table.tolist())


def _derivation(model: str | None) -> Any:
    """The derivation through the order of the emitted modules."""
    from derivation.modules import EMITTED_ORDER
    from rodwnl.kernels import DEFAULT
    from rodwnl.models import derivation_of

    return derivation_of(model or DEFAULT, EMITTED_ORDER)


def _write(path: Path, text: str) -> None:
    from rodwnl.storage import replacing

    with replacing(path) as temporary:
        temporary.write_text(text, encoding="utf-8", newline="\n")
    print(f"{path}: {len(text.splitlines())} lines", file=sys.stderr)
