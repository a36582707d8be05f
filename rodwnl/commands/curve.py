"""`rodwnl curve`: a threshold as a parameter of the rod varies, and the special points on it."""

from typing import TYPE_CHECKING, Annotated, Any

import typer

from rodwnl import kernels
from rodwnl.errors import InputError
from rodwnl.options import Json, Model, Parameter, read_model
from rodwnl.output import complex_number, full_texts, number, print_json, print_table
from rodwnl.parameters import PLAIN, RodParameters, decimal_text, exact, positive, shown

if TYPE_CHECKING:
    from rodwnl.curves import Curve, SpecialPoint

NAMES = ("k1", "k2", "gamma3", "gamma1")
Value = Annotated[str | None, typer.Option(metavar="X", help="As for `rodwnl landau`; not if it is varied.")]


def command(
    vary: Annotated[str, typer.Option(metavar="NAME[,NAME]", help="The parameter, or two of them.")],
    start: Annotated[str, typer.Option("--from", metavar="X[,X]", help="Where they begin.")],
    stop: Annotated[str, typer.Option("--to", metavar="X[,X]", help="Where they end.")],
    k1: Value = None,
    k2: Value = None,
    gamma3: Value = None,
    gamma1: Value = None,
    threshold: Annotated[int, typer.Option(metavar="N", help="Which threshold, by increasing force.")] = 1,
    model: Model = None,
    parameter: Parameter = None,
    json: Json = False,
) -> None:
    """Follow a Hopf threshold as a parameter varies, through turning points, and locate the special points.

    Special points: bautin (super- becomes subcritical), closing (two thresholds meet and vanish), double (two
    pairs of eigenvalues on the axis at once). With two parameters, --vary k1,k2, the special points found as
    the first one varies are followed as curves in the plane until the second one is at its end.
    """
    from rodwnl.curves import equations, special_curve, threshold_curve, unit
    from rodwnl.spectrum import hopf_thresholds

    other = read_model(model, parameter or [])
    names = _names(vary, other.get("model"))
    begin, end = _numbers("--from", start, names), _numbers("--to", stop, names)
    for name, a, b in zip(names, begin, end, strict=True):
        if a == b:
            raise InputError(f"--from and --to are both {shown(a)} for {name}: there is nothing to vary")
    given = {"k1": k1, "k2": k2, "gamma3": gamma3, "gamma1": gamma1} | other
    rod = _rod(given, dict(zip(names, begin, strict=True)))
    units = {name: unit(name, a, b) for name, a, b in zip(names, begin, end, strict=True)}
    equations(rod, units)  # refuses what has no curves before the search
    search = hopf_thresholds(rod)
    if not 1 <= threshold <= len(search):
        raise InputError(
            f"--threshold is {threshold}, but the rod at the start of the curve has {len(search)} "
            f"threshold{'' if len(search) == 1 else 's'} up to force {decimal_text(search.max_force)}"
        )
    at = search[threshold - 1]
    curve, special = threshold_curve(rod, names[0], (at.force, at.omega), end[0])
    pair = (names[0], names[-1])
    curves = [(p, special_curve(p, pair, end[1])) for p in special] if len(names) == 2 else []
    if json:
        document: dict[str, Any] = {
            "rod": rod.texts() | ({} if rod.model == PLAIN else {"model": rod.model_name}),
            "vary": list(names),
            "points": [_point(p, rod, names) for p in special],
            "curve": _curve(curve),
        }
        if len(names) == 2:
            document["curves"] = [{"type": p.type} | _curve(c) for p, c in curves]
        print_json(document)
        return
    _print(rod, names, curve, special, curves)


def _names(text: str, model: str | None) -> list[str]:
    names = [name.strip() for name in text.split(",")]
    known = (*NAMES, *(kernels.own_parameters(model) if model else ()))
    for name in names:
        if name not in known:
            raise InputError(f"--vary is {shown(text)}, but what can vary is {', '.join(known)}")
    if len(names) > 2 or len(set(names)) < len(names):
        raise InputError(f"--vary is {shown(text)}, but it takes one parameter or two different ones")
    if names[0] == "gamma1":
        raise InputError("gamma1 does not move thresholds: give another parameter first, and gamma1 second")
    return names


def _numbers(option: str, text: str, names: list[str]) -> list[float]:
    texts = [part.strip() for part in text.split(",")]
    if len(texts) != len(names):
        raise InputError(f"{option} is {shown(text)}, but it needs one value for each of {', '.join(names)}")
    return [
        float((positive if name in NAMES else exact)(f"{option} ({name})", part))
        for name, part in zip(names, texts, strict=True)
    ]


def _rod(given: dict[str, str | None], varied: dict[str, float]) -> RodParameters:
    for name in varied:
        if given.get(name) is not None:
            option = name if name in NAMES else f"parameter {name}"
            raise InputError(f"--{option} is given, but {name} varies: it begins at --from")
    values: dict[str, Any] = {name: value for name, value in given.items() if value is not None} | varied
    if missing := [name for name in NAMES[:3] if name not in values]:
        raise InputError(f"the rod also needs {' and '.join(f'--{name}' for name in missing)}")
    return RodParameters(**values)


def _point(p: "SpecialPoint", rod: RodParameters, names: list[str]) -> dict[str, Any]:
    values = rod.texts() | {name: repr(p.rod[name]) for name in names}
    second = {} if p.omega2 is None else {"omega2": repr(p.omega2)}
    coefficients = {name: full_texts(z) for name, z in (("alpha", p.alpha), ("beta", p.beta))}
    whole = {"type": p.type} | values | {"force": repr(p.force), "omega": repr(p.omega)} | second
    return whole | coefficients | {"relative_error": repr(p.error)}


def _curve(curve: "Curve") -> dict[str, Any]:
    def texts(numbers: Any) -> list[str]:
        return [repr(x) for x in numbers.tolist()]

    columns = {name: texts(curve.rods[name]) for name in curve.vary}
    columns |= {"force": texts(curve.force), "omega": texts(curve.omega)}
    if curve.omega2 is not None:
        columns["omega2"] = texts(curve.omega2)
    for name, numbers in (("alpha", curve.alpha), ("beta", curve.beta)):
        columns[f"{name}_re"], columns[f"{name}_im"] = texts(numbers.real), texts(numbers.imag)
    return columns | {"other_unstable_pairs": curve.others.tolist(), "end": curve.end}


def _print(
    rod: RodParameters,
    names: list[str],
    curve: "Curve",
    special: "tuple[SpecialPoint, ...]",
    curves: "list[tuple[SpecialPoint, Curve]]",
) -> None:
    which = "" if rod.model == PLAIN else f" of the rod {rod.model_name!r}"
    fixed = ", ".join(f"{name} = {text}" for name, text in rod.texts().items() if name not in names)
    print(
        f"A threshold{which} as {names[0]} varies, with {fixed}: {len(curve.force)} points until {curve.end}."
    )
    rows = [
        [
            what,
            *(f"{x:.6g}" for x in (curve.rods[names[0]][i], curve.force[i], curve.omega[i])),
            "",
            "",
        ]
        for what, i in (("start", 0), ("end", -1))
    ]
    placed = [
        [
            p.type, number(p.rod[names[0]], p.error * (p.units[names[0]] or p.rod[names[0]])),
            number(p.force, p.error * p.force), number(p.omega, p.error * p.omega),
            complex_number(p.alpha, 1e-8 * abs(p.alpha)), complex_number(p.beta, 1e-8 * abs(p.beta)),
        ]
        for p in special
    ]  # fmt: skip
    print_table(["", names[0], "force", "omega", "alpha", "beta"], [rows[0], *placed, rows[1]])
    if not special:
        print("There are no special points on it.")
    for p, followed in curves:
        print(
            f"The {p.type} point from {names[0]} = {p.rod[names[0]]:.8g} as {names[1]} varies, "
            f"until {followed.end}:"
        )
        columns = [followed.rods[name] for name in followed.vary] + [
            followed.force,
            followed.omega,
        ]
        picked = sorted({round(i * (len(followed.force) - 1) / 8) for i in range(9)})
        print_table([*followed.vary, "force", "omega"], [[f"{c[i]:.8g}" for c in columns] for i in picked])
