"""Which rods a sweep computes: a grid or a sampling of their parameters, read from a TOML file.

    max_force = 400                                      # optional; else 400, or where the rod ends
    model = "quartic"                                    # optional; or a rod.toml, beside this file

    [k1]
    log = [20, 1e6]                                      # from, to; or linear = [from, to]
    points = 200

    [k2]
    values = [1e2, 1e4]

    [gamma3]
    value = 1e-4                                         # gamma1 = 1/2 unless it is given

    [stretch4]                                           # a parameter of the model's own, else its default
    linear = [0, 200]
    points = 5

    [sampling]                                           # optional; without it every combination
    method = "sobol"                                     # or "latin-hypercube"
    points = 4096
    seed = 0

A sampling draws from the ranges of the axes with `log` or `linear` (then without `points`).
"""

from __future__ import annotations

import difflib
import json
import os
import tomllib
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from math import ceil, prod
from pathlib import Path
from typing import Any

import numpy as np

from rodwnl import kernels
from rodwnl.batch_characteristic import Real
from rodwnl.errors import InputError
from rodwnl.models import emitted, is_file
from rodwnl.parameters import PLAIN, exact, positive, shown

NAMES = ("k1", "k2", "gamma3", "gamma1")
SCALES = ("log", "linear")
METHODS = ("latin-hypercube", "sobol")
MOST_RODS = 10**9
SEED = 0


@dataclass(frozen=True)
class Block:
    """Some rods of a grid: a slice of each dimension."""

    slices: tuple[slice, ...]

    @property
    def shape(self) -> tuple[int, ...]:
        return tuple(s.stop - s.start for s in self.slices)


@dataclass(frozen=True)
class Grid:
    """Rods of shape `shape`, along the dimensions `dims`.

    Of a full grid the dimensions are the parameters with more than one value, in the order k1, k2, gamma3,
    gamma1 and the model's own; of a sampling there is one, `rod`. values: per parameter its values, (),
    (length of its dimension,) or (rods,). description: what identifies the grid, as JSON. model: as
    `RodParameters` takes it.
    """

    dims: tuple[str, ...]
    shape: tuple[int, ...]
    values: dict[str, Real]
    max_force: float | None
    description: str
    model: str = PLAIN

    @property
    def size(self) -> int:
        return prod(self.shape)

    def blocks(self, most: int) -> Iterator[Block]:
        """The grid in blocks of at most `most` rods, in C order; a block is whole along later dimensions."""
        block = list(self.block_shape(most))
        counts = [ceil(n / b) for n, b in zip(self.shape, block, strict=True)]
        for number in np.ndindex(*counts):
            edges = zip(number, block, self.shape, strict=True)
            yield Block(tuple(slice(i * b, min((i + 1) * b, n)) for i, b, n in edges))

    def block_shape(self, most: int) -> tuple[int, ...]:
        """The shape of all blocks but those at the edges."""
        shape: list[int] = []
        for length in reversed(self.shape):
            shape.insert(0, min(length, max(most // prod(shape), 1)))
        return tuple(shape)

    def rods(self, block: Block) -> dict[str, Real]:
        """Every parameter by name, each of the block's shape."""

        def part(name: str) -> Real:
            values = self.values[name]
            if values.ndim == 0:
                return values
            dim = self.dims.index(name if name in self.dims else "rod")
            along = [1] * len(self.dims)
            along[dim] = -1
            return values[block.slices[dim]].reshape(along)

        return {name: np.broadcast_to(part(name), block.shape) for name in self.values}


def read_grid(path: Path, model: str | None = None, own: Mapping[str, str] | None = None) -> Grid:
    """The grid in a TOML file; model and own, if given, are what the command line says, in place of the file.

    Raises InputError, naming the file, for whatever is not a grid.
    """
    try:
        content = tomllib.loads(path.read_text(encoding="utf-8"))
    except OSError as error:
        raise InputError(f"cannot read {path}: {error.strerror}") from None
    except (tomllib.TOMLDecodeError, UnicodeDecodeError) as error:
        raise InputError(f"{path} is not TOML: {error}") from None
    try:
        given = _with_options(content, model, own or {})
        return grid(given, _model(given["model"], path.parent) if "model" in given else PLAIN)
    except InputError as error:
        raise InputError(f"{path}: {error}") from None


def _with_options(content: dict[str, Any], model: str | None, own: Mapping[str, str]) -> dict[str, Any]:
    """The document with a model (the path of a file from here) and values given on the command line."""
    if model is not None and "model" in content:
        raise InputError(f"it names a model, {shown(content['model'])}: leave out --model")
    for name in own:
        if name in content:
            raise InputError(f"it says what {name} is: leave out --parameter {name}")
    named = {} if model is None else {"model": os.path.abspath(model) if is_file(model) else model}
    return content | named | {name: {"value": value} for name, value in own.items()}


def grid(content: dict[str, Any], model: str = PLAIN) -> Grid:
    """The grid that a TOML document describes, of rods of this model. Raises InputError."""
    own = kernels.own_parameters(model)
    names = (*NAMES, *own)
    _known("key", content, (*names, "max_force", "sampling", "model"))
    if missing := [name for name in NAMES[:3] if name not in content]:
        raise InputError(
            f"there is no {' and no '.join(missing)}: write for example [{missing[0]}] value = 1e4"
        )
    default = {"gamma1": {"value": 0.5}} | {name: {"value": text} for name, text in own.items()}
    tables = default | {name: content[name] for name in names if name in content}
    max_force = float(positive("max_force", content["max_force"])) if "max_force" in content else None
    sampling = _sampling(content["sampling"]) if "sampling" in content else None
    axes = {name: _axis(name, tables[name], sampling is not None, own=name in own) for name in names}
    described = {"axes": {name: tables[name] for name in names}, "max_force": max_force, "sampling": sampling}
    description = json.dumps(described, default=str)
    if sampling:
        return _sample(axes, sampling, max_force, description, model)
    size = prod(axis.points if isinstance(axis, Range) else np.size(axis) for axis in axes.values())
    if size > MOST_RODS:
        raise InputError(f"the grid has {size} rods, more than {MOST_RODS}: coarsen it or cut it in parts")
    values = {name: _points(axis) for name, axis in axes.items()}
    dims = tuple(name for name in names if values[name].ndim)
    if not dims:
        values["k1"], dims = values["k1"].reshape(1), ("k1",)
    return Grid(dims, tuple(len(values[name]) for name in dims), values, max_force, description, model)


def _model(text: Any, folder: Path) -> str:
    if not isinstance(text, str):
        raise InputError(f"model must be a name or the path of a rod.toml, not {shown(text)}")
    return emitted(str(folder / text) if is_file(text) else text)


@dataclass(frozen=True)
class Range:
    """Values from `low` to `high`, evenly spaced by themselves or by their logarithms; `points` of them."""

    scale: str
    low: float
    high: float
    points: int

    def at(self, fraction: Real) -> Real:
        if self.scale == "linear":
            return self.low + (self.high - self.low) * fraction
        return np.asarray(np.exp(np.log(self.low) + np.log(self.high / self.low) * fraction))


Axis = float | list[float] | Range


def _points(axis: Axis) -> Real:
    if not isinstance(axis, Range):
        return np.array(axis)
    values = axis.at(np.linspace(0, 1, axis.points))
    values[0] = axis.low  # exactly, whatever the logarithm does
    if axis.points > 1:
        values[-1] = axis.high
    return values


def _axis(name: str, table: Any, sampled: bool, own: bool = False) -> Axis:
    """One parameter's table; a model's own parameters need not be positive."""
    read = exact if own and not (isinstance(table, dict) and "log" in table) else positive
    if not isinstance(table, dict):
        table = {"value": table}
    _known(f"key of [{name}]", table, ("value", "values", *SCALES, "points"))
    kinds = [kind for kind in ("value", "values", *SCALES) if kind in table]
    if len(kinds) != 1:
        raise InputError(
            f"[{name}] needs exactly one of value, values, log, linear, not {' and '.join(kinds) or 'none'}"
        )
    kind = kinds[0]
    if kind not in SCALES and "points" in table:
        raise InputError(f"[{name}] points goes with log or linear, not with {kind}")
    if kind == "value":
        return float(read(name, table[kind]))
    if not isinstance(table[kind], list):
        raise InputError(f"[{name}] {kind} must be a list, not {shown(table[kind])}")
    numbers = [float(read(name, value)) for value in table[kind]]
    if kind == "values":
        if sampled:
            raise InputError(f"[{name}] values cannot be sampled: give log, linear or value")
        if not numbers:
            raise InputError(f"[{name}] values is empty: the grid has no points")
        if len(set(numbers)) < len(numbers):
            raise InputError(f"[{name}] values names a value twice")
        return numbers
    if len(numbers) != 2 or not numbers[0] < numbers[1]:
        raise InputError(f"[{name}] {kind} must be [from, to] with from < to, not {shown(table[kind])}")
    if sampled:
        if "points" in table:
            raise InputError(f"[{name}] points does not go with [sampling], which has its own")
        return Range(kind, numbers[0], numbers[1], points=0)
    if "points" not in table:
        raise InputError(f"[{name}] {kind} also needs points")
    return Range(kind, numbers[0], numbers[1], _whole(f"[{name}] points", table["points"]))


def _sampling(table: Any) -> dict[str, Any]:
    if not isinstance(table, dict):
        raise InputError(f"sampling must be a table with method and points, not {shown(table)}")
    _known("key of [sampling]", table, ("method", "points", "seed"))
    if missing := [key for key in ("method", "points") if key not in table]:
        raise InputError(f"[sampling] also needs {' and '.join(missing)}")
    if table["method"] not in METHODS:
        raise InputError(f"[sampling] method is {shown(table['method'])}; there are {', '.join(METHODS)}")
    return {
        "method": table["method"],
        "points": _whole("[sampling] points", table["points"]),
        "seed": _whole("[sampling] seed", table.get("seed", SEED), least=0),
    }


def _sample(
    axes: dict[str, Axis], sampling: dict[str, Any], max_force: float | None, description: str, model: str
) -> Grid:
    from scipy.stats import qmc

    free = {name: axis for name, axis in axes.items() if isinstance(axis, Range)}
    if not free:
        raise InputError("[sampling] has nothing to draw: no parameter has a range log or linear")
    points = sampling["points"]
    if points > MOST_RODS:
        raise InputError(f"the sampling has {points} rods, more than {MOST_RODS}")
    if sampling["method"] == "sobol":
        # drawn in a power of two, as the sequence is balanced only there, and cut
        unit = qmc.Sobol(len(free), rng=sampling["seed"]).random_base2(max(points - 1, 0).bit_length())[
            :points
        ]
    else:
        unit = qmc.LatinHypercube(len(free), rng=sampling["seed"]).random(points)
    values = {name: np.array(axis) for name, axis in axes.items() if not isinstance(axis, Range)}
    values |= {name: axis.at(unit[:, i]) for i, (name, axis) in enumerate(free.items())}
    return Grid(("rod",), (points,), {name: values[name] for name in axes}, max_force, description, model)


def _whole(name: str, value: Any, least: int = 1) -> int:
    number = exact(name, value)
    if number.denominator != 1 or number < least:
        raise InputError(f"{name} is {shown(value)}, but it must be a whole number, {least} or more")
    return int(number)


def _known(what: str, table: dict[str, Any], known: tuple[str, ...]) -> None:
    for key in table:
        if key not in known:
            nearest = difflib.get_close_matches(key, known, n=1, cutoff=0.3)
            hint = f"did you mean {nearest[0]}?" if nearest else f"there are {', '.join(known)}"
            raise InputError(f"unknown {what} {shown(key)}: {hint}")
