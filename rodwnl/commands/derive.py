"""`rodwnl derive`: from the exact kinematics to the committed modules of `generated`."""

from pathlib import Path
from typing import Annotated, Literal

import typer

from rodwnl.errors import InputError

Format = Literal["text", "latex", "python"]


def command(
    out: Annotated[
        Path | None, typer.Option(metavar="DIR", help="Folder to write instead of the package in use.")
    ] = None,
    check: Annotated[
        bool, typer.Option("--check", help="Write nothing; print a diff and exit 1 if files differ.")
    ] = False,
    show: Annotated[str | None, typer.Option(metavar="NAME", help="Print a derived object, g3 say.")] = None,
    form: Annotated[Format | None, typer.Option("--format", help="With --show. Default: text.")] = None,
) -> int:
    """Derive the theory from the rod's exact kinematics and write the package `generated`.

    The same rod gives the same bytes. Without --out the package of this source tree is rewritten.
    """
    if show is not None:
        if check or out is not None:
            raise InputError("--show prints an object and writes nothing: leave out --check and --out")
        return _show(show, form or "text")
    if form is not None:
        raise InputError("--format says how --show NAME prints: add --show, or leave it out")

    from derivation.emit.write import difference, render, write
    from derivation.modules import EMITTED_ORDER, package
    from derivation.pipeline import derive
    from rodwnl.kernels import source_folder

    folder = source_folder() if out is None else out
    if folder.exists() and not folder.is_dir():
        raise InputError(f"{folder} is a file: --out needs a folder")
    files = render(package(derive(order=EMITTED_ORDER)))
    if check:
        diff = difference(files, folder)
        print(diff or f"{folder}: {len(files)} files, as derived", end="" if diff else "\n")
        return 1 if diff else 0
    changed = write(files, folder)
    print(f"{folder}: {len(files)} files, {len(changed)} changed", *changed, sep="\n  ")
    return 0


def _show(name: str, form: Format) -> int:
    from derivation.catalogue import objects
    from derivation.emit.show import show
    from derivation.pipeline import derive
    from derivation.symbols import latex_names

    known = objects(derive())
    if name not in known:
        raise InputError(f"nothing derived is called {name!r}; there are {', '.join(known)}")
    equations = known[name].equations
    one = len(equations) == 1 and str(equations[0].lhs) == name
    print(show(name, equations[0].rhs if one else equations, form, latex_names()))
    return 0
