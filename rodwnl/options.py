"""The options that commands share, and how the texts given there become a rod and a force.

Numbers arrive as text and are read exactly; nothing is rounded before the numerics.
"""

import inspect
from collections.abc import Callable, Sequence
from fractions import Fraction
from pathlib import Path
from typing import Annotated, Any

import typer

from rodwnl.errors import InputError
from rodwnl.parameters import RodParameters, exact, positive, shown
from rodwnl.storage import require_apart

Json = Annotated[bool, typer.Option("--json", help="Print one JSON document, numbers as decimal texts.")]
MaxForce = Annotated[
    str | None,
    typer.Option(
        "--max-force",
        metavar="F",
        help="Search forces up to this one. Default: 400, or where the straight rod ends before.",
    ),
]

Digits = Annotated[
    str | None,
    typer.Option("--digits", metavar="N", help="Print N correct digits (1 to 10000), whatever it takes."),
]
Certified = Annotated[
    bool,
    typer.Option(
        "--certified", help="Prove existence, uniqueness, rank and criticality; print every number as a ball."
    ),
]
Order = Annotated[int, typer.Option(metavar="N", help="Order of the amplitude equation: 3 (default) or 5.")]
Complete = Annotated[
    bool,
    typer.Option(
        "--complete",
        help="With --certified: prove that there are no other thresholds (takes a minute or two).",
    ),
]
Convention = Annotated[
    str | None,
    typer.Option(
        "--convention",
        metavar="NAME",
        help="Print the coefficient as another tool reports it too: paper, kuznetsov, matcont, "
        "bifurcationkit, jaxcont or ff-bifbox.",
    ),
]
NoEscalate = Annotated[
    bool,
    typer.Option("--no-escalate", help="Stay in double precision where it gives fewer than 8 digits."),
]
Mesh = Annotated[
    str | None,
    typer.Option("--mesh", metavar="N", help="Intervals of the mesh on which a convention takes a 2-norm."),
]

_REQUIRED = {"k1": "Stretch stiffness.", "k2": "Shear stiffness.", "gamma3": "Rotational drag."}
_OPTIONAL = {"gamma1": "Axial drag. Default: half the transverse drag."}
_SI = {
    "length": "Length (m). Given with --k3 and --gamma2, values are read and tables printed in SI units; "
    "--json stays dimensionless, with the scales beside.",
    "k3": "Bending stiffness (N m²).",
    "gamma2": "Transverse drag (N s/m²).",
}


_MODEL = typer.Option(
    "--model", metavar="NAME|FILE", help="Another rod: a shipped one, or a rod.toml. Default: follower."
)
_PARAMETER = typer.Option(
    "--parameter", metavar="NAME=X", help="A parameter that only this model has, dimensionless. Repeatable."
)
Model = Annotated[str | None, _MODEL]
Parameter = Annotated[list[str] | None, _PARAMETER]


def takes_rod(command: Callable[..., Any]) -> Callable[..., Any]:
    """Replace the parameter `rod` of a command by the options --k1, --k2, … that describe a rod."""
    signature = inspect.signature(command, eval_str=True)

    keyword, required = inspect.Parameter.KEYWORD_ONLY, inspect.Parameter.empty

    def options(texts: dict[str, str], type_: Any, default: Any) -> list[inspect.Parameter]:
        annotation = {
            name: Annotated[type_, typer.Option(f"--{name}", metavar="X", help=text)]
            for name, text in texts.items()
        }
        return [inspect.Parameter(n, keyword, default=default, annotation=a) for n, a in annotation.items()]

    own = [p.replace(kind=keyword) for name, p in signature.parameters.items() if name != "rod"]
    parameters = [
        *options(_REQUIRED, str, required),
        *options(_OPTIONAL, str | None, None),
        inspect.Parameter("model", keyword, default=None, annotation=Model),
        inspect.Parameter("parameter", keyword, default=None, annotation=Parameter),
        *own,
        *options(_SI, str | None, None),
    ]

    def with_rod(**given: Any) -> Any:
        values = {name: given.pop(name) for name in (*_REQUIRED, *_OPTIONAL, *_SI, "model", "parameter")}
        for output in (value for value in given.values() if isinstance(value, Path)):
            require_apart(output, values["model"])
        return command(rod=read_rod(values), **given)

    with_rod.__doc__ = command.__doc__
    with_rod.__signature__ = signature.replace(parameters=parameters)  # type: ignore[attr-defined]
    with_rod.__annotations__ = {p.name: p.annotation for p in parameters}
    return with_rod


def read_rod(values: dict[str, Any]) -> RodParameters:
    """The rod that the options describe: in SI units when --length, --k3 and --gamma2 are there."""
    own: dict[str, Any] = {n: values[n] for n in (*_REQUIRED, *_OPTIONAL) if values[n] is not None}
    own |= read_model(values.get("model"), values.get("parameter") or [])
    si = {name: values[name] for name in _SI if values[name] is not None}
    if not si:
        return RodParameters(**own)
    if len(si) < len(_SI):
        missing = " and ".join(f"--{name}" for name in _SI if name not in si)
        raise InputError(f"a rod in SI units also needs {missing}")
    own.setdefault("gamma1", positive("gamma2", si["gamma2"]) / 2)
    return RodParameters.from_physical(L=si.pop("length"), **own, **si)


def read_model(model: str | None, assignments: Sequence[str]) -> dict[str, str]:
    """The model, and the values of its own parameters, as `RodParameters` takes them."""
    own = read_assignments(assignments)
    if model is None:
        if own:
            raise InputError("--parameter sets what only another model has: name that one with --model")
        return {}
    from rodwnl.models import emitted

    return {"model": emitted(model), **own}


def read_assignments(assignments: Sequence[str]) -> dict[str, str]:
    """Values of a model's own parameters, given as NAME=VALUE."""
    own: dict[str, str] = {}
    for text in assignments:
        name, equals, value = (part.strip() for part in text.partition("="))
        if not (name and equals and value) or name in {*_REQUIRED, *_OPTIONAL, *_SI, "model", "scales"}:
            raise InputError(
                f"--parameter {shown(text)}: write it as NAME=VALUE, with a name of the model's own"
            )
        if name in own:
            raise InputError(f"--parameter {name} is given twice")
        own[name] = value
    return own


def read_digits(text: str | None) -> int | None:
    """A number of digits; None stands for the default."""
    from rodwnl.exact import checked_digits

    if text is None:
        return None
    return checked_digits(int(text) if text.isascii() and text.isdigit() and len(text) < 9 else text)


def read_convention(name: str | None, mesh: str | None) -> tuple[str, int | None] | None:
    """A convention and its mesh; None stands for the paper's, without conversion."""
    if name is None:
        if mesh is not None:
            raise InputError("--mesh belongs to --convention")
        return None
    from rodwnl.dialects import checked_mesh

    return name, checked_mesh(name, mesh)


def read_force(rod: RodParameters, name: str, text: str) -> Fraction:
    """A force given on the command line, made dimensionless when the rod was given in SI units."""
    return exact(name, text) / (rod.scales.force if rod.scales else 1)


def read_max_force(rod: RodParameters, text: str | None) -> Fraction | None:
    """The end of the range to search; None stands for the default."""
    return None if text is None else read_force(rod, "max_force", text)
