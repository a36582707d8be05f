"""`rodwnl derive`: from the exact kinematics to the committed modules of `generated`."""

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Literal

import typer

from rodwnl.errors import InputError

if TYPE_CHECKING:
    from derivation.model import RodModel

Format = Literal["text", "latex", "python"]


def command(
    model: Annotated[
        str | None, typer.Option(metavar="NAME|FILE", help="One rod: a shipped one, or a rod.toml.")
    ] = None,
    out: Annotated[
        Path | None, typer.Option(metavar="DIR", help="Folder to write instead of the package in use.")
    ] = None,
    check: Annotated[
        bool, typer.Option("--check", help="Write nothing; print a diff and exit 1 if files differ.")
    ] = False,
    show: Annotated[str | None, typer.Option(metavar="NAME", help="Print a derived object, g3 say.")] = None,
    explain: Annotated[
        str | None, typer.Option(metavar="NAME", help="Print the steps from the kinematics to an object.")
    ] = None,
    form: Annotated[Format | None, typer.Option("--format", help="With --show. Default: text.")] = None,
    order: Annotated[
        int | None,
        typer.Option(metavar="N", help="With --show or --explain: derive to order 3 (default), 5, 7, ..."),
    ] = None,
) -> int:
    """Derive the theory from the rod's exact kinematics and write the package `generated`.

    Without --model all shipped rods are derived. The same rod gives the same bytes. Without --out the
    package of this source tree is rewritten.
    """
    if explain is not None:
        if check or out is not None or show is not None:
            raise InputError("--explain prints steps and writes nothing: leave out --check, --out and --show")
        return _explain(model, explain, form or "text", _checked(order))
    if show is not None:
        if check or out is not None:
            raise InputError("--show prints an object and writes nothing: leave out --check and --out")
        return _show(model, show, form or "text", _checked(order))
    if form is not None:
        raise InputError("--format says how --show NAME prints: add --show, or leave it out")
    if order is not None:
        raise InputError("--order goes with --show or --explain: what is written goes to order 5 in any case")

    from derivation.emit.write import difference, foreign, render, write
    from derivation.model import MODELS
    from derivation.modules import EMITTED_ORDER, package
    from derivation.pipeline import derive
    from rodwnl.kernels import source_folder
    from rodwnl.models import find_model, refusals

    rods = list(MODELS.values()) if model is None else [find_model(model)]
    if out is None and rods[0].name not in MODELS:
        raise InputError(f"{model} is no rod of this source tree: say where to write with --out DIR")
    folder = source_folder() if out is None else out
    if folder.exists() and not folder.is_dir():
        raise InputError(f"{folder} is a file: --out needs a folder")
    with refusals(model or "the shipped rods"):
        files = render(*(package(derive(rod, order=EMITTED_ORDER)) for rod in rods))
    if check:
        diff = difference(files, folder, alone=model is None)
        print(diff or f"{folder}: {len(files)} files, as derived", end="" if diff else "\n")
        return 1 if diff else 0
    if out is not None and (others := foreign(files, out)):
        raise InputError(f"{out / others[0]} was not written by `rodwnl derive`: choose another folder")
    changed = write(files, folder)
    print(f"{folder}: {len(files)} files, {len(changed)} changed", *changed, sep="\n  ")
    return 0


def _checked(order: int | None) -> int:
    """Raises InputError for an order at which the amplitude equation gains no term, or far beyond use."""
    if order is None:
        return 3
    if order not in (3, 5, 7, 9):
        raise InputError(
            f"--order is {order}, but the amplitude equation gains terms at the orders 3, 5, 7 and 9"
        )
    return order


def _show(model: str | None, name: str, form: Format, order: int) -> int:
    from derivation.catalogue import objects
    from derivation.emit.show import show
    from derivation.model import FOLLOWER
    from derivation.pipeline import derive
    from derivation.symbols import latex_names
    from rodwnl.models import find_model, refusals

    rod: RodModel = FOLLOWER if model is None else find_model(model)
    with refusals(model or rod.name):
        known = objects(derive(rod, order))
    if name not in known:
        raise InputError(f"nothing derived is called {name!r}; there are {', '.join(known)}")
    equations = known[name].equations
    one = len(equations) == 1 and str(equations[0].lhs) == name
    print(show(name, equations[0].rhs if one else equations, form, latex_names()))
    return 0


def _explain(model: str | None, name: str, form: Format, order: int) -> int:
    from derivation.catalogue import objects
    from derivation.emit.show import show
    from derivation.explain import thoughts
    from derivation.model import FOLLOWER
    from derivation.pipeline import derive
    from derivation.symbols import latex_names
    from rodwnl.models import find_model, refusals

    rod: RodModel = FOLLOWER if model is None else find_model(model)
    with refusals(model or rod.name):
        derivation = derive(rod, order)
    known = objects(derivation)
    if name not in known:
        raise InputError(f"nothing derived is called {name!r}; there are {', '.join(known)}")
    for number, thought in enumerate(thoughts(name, derivation), 1):
        print(f"{number}. {thought.title[0].upper()}{thought.title[1:]}")
        for step in thought.steps:
            where = f" ({step.object.label})" if step.object.label else ""
            print(f"   {step.object.name}{where}, derivation/{step.object.stage}.py: {step.because}")
            equations = step.object.equations
            whole = equations if len(equations) > 1 else equations[0]
            body = show(step.object.name, whole, form, latex_names())
            print("\n".join(f"      {line}" for line in body.splitlines()))
        print()
    return 0
