"""Sweeps: thresholds and Landau coefficients of all rods of a grid, in one described file.

The grid is cut into blocks. Each finished block is put into a folder beside the output by one rename, and
when all are there the output is put together from them, in their order, and renamed into place. So a sweep
that was killed at any moment goes on with the blocks that are missing, and what comes out does not depend
on whether it was, nor on how many workers there were.
"""

from __future__ import annotations

import json
import re
import shutil
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from itertools import islice
from pathlib import Path
from typing import Any, cast

import numpy as np

from rodwnl import __version__, kernels
from rodwnl.batch import ACCURACY, MOST, PER_ROD, Status
from rodwnl.batch_characteristic import Real
from rodwnl.engines import Values, on_dask, on_this_machine
from rodwnl.errors import InputError
from rodwnl.grids import Block, Grid
from rodwnl.storage import file_attributes, replacing, require, require_writable
from rodwnl.workers import cores

BLOCK = 8192  # rods
MOST_REASONS = 1000  # kept in the file
# In the folder of parts: finished blocks, the plan, an output not yet whole, and what a killed run half wrote
PART = re.compile(r"\d{6}\.npz|plan\.json|whole\.(nc|zarr)|\.(\d{6}\.npz|plan\.json)\..*")

Progress = Callable[[int, int], None]  # rods done, rods in all

# name: (dtype, unit, description); all but those of PER_ROD once per threshold
VARIABLES = {
    "status": ("i1", "1", "how the search ended for this rod"),
    "count": ("i1", "1", "number of Hopf thresholds of the leading eigenvalue in the range searched"),
    "buckling_force": ("f8", "k3 L-2", "force at which a leading real eigenvalue first crosses zero"),
    "force": ("f8", "k3 L-2", "force F_c at the threshold"),
    "omega": ("f8", "k3 gamma2-1 L-4", "frequency at the threshold"),
    "alpha_re": ("f8", "k3 gamma2-1 L-6", "real part of alpha; dA/dt = alpha |A|^2 A + beta (F - F_c) A"),
    "alpha_im": ("f8", "k3 gamma2-1 L-6", "imaginary part of alpha"),
    "beta_re": ("f8", "gamma2-1 L-2", "real part of beta, the slope of the leading eigenvalue in the force"),
    "beta_im": ("f8", "gamma2-1 L-2", "imaginary part of beta"),
    "A_tip2_slope": ("f8", "k3-1 L4", "slope of the squared tip amplitude in the force, at onset"),
    "omega_slope": ("f8", "gamma2-1 L-2", "slope of the frequency in the force, at onset"),
    "crossing": ("i1", "1", "+1 destabilizing, -1 restabilizing, 0 no threshold"),
    "residual": ("f8", "1", "largest relative residual of threshold, modes and corrections"),
    "error": ("f8", "1", "estimated relative error of alpha and beta"),
}  # fmt: skip
PARAMETERS = {
    "k1": ("k3 L-2", "stretch stiffness"),
    "k2": ("k3 L-2", "shear stiffness"),
    "gamma3": ("gamma2 L2", "rotational drag"),
    "gamma1": ("gamma2", "axial drag"),
}


@dataclass(frozen=True)
class Plan:
    """A grid, where its sweep goes, and what identifies both: `provenance` stands in the file."""

    grid: Grid
    out: Path
    provenance: dict[str, str]

    @property
    def parts(self) -> Path:
        whole = self.out.resolve()
        return whole.with_name(whole.name + ".parts")

    def part(self, number: int) -> Path:
        return self.parts / f"{number:06d}.npz"

    @property
    def blocks(self) -> list[Block]:
        return list(self.grid.blocks(BLOCK))


def sweep(
    grid: Grid,
    out: Path,
    *,
    workers: int | None = None,
    scheduler: str | None = None,
    resume: bool = False,
    overwrite: bool = False,
    progress: Progress = lambda done, total: None,
) -> None:
    """Compute all rods of the grid and write them to `out`, a .nc file or a .zarr folder.

    workers: processes on this machine (default: one a core), or scheduler: the address of a Dask scheduler.
    resume: go on with what an earlier run of the same grid left; overwrite: begin anew. Raises InputError
    before any work where the output cannot be written, exists already, or was made by another grid or
    version; ComputationError where workers keep dying.
    """
    plan = prepare(grid, out, resume=resume, overwrite=overwrite)
    if out.exists():
        return
    blocks = plan.blocks
    missing = [i for i in range(len(blocks)) if not plan.part(i).exists()]
    done = grid.size - sum(_size(blocks[i]) for i in missing)
    progress(done, grid.size)
    tasks = ((i, grid.rods(blocks[i]), grid.max_force, grid.model) for i in missing)
    results = on_dask(tasks, scheduler) if scheduler else on_this_machine(tasks, workers or cores())
    try:
        for number, values in results:
            with replacing(plan.part(number)) as temporary, temporary.open("wb") as file:
                np.savez(file, **cast(Any, values))
            done += _size(blocks[number])
            progress(done, grid.size)
    finally:
        if not done:  # nothing to go on with
            shutil.rmtree(plan.parts)
    (_to_zarr if out.suffix == ".zarr" else _to_netcdf)(plan)
    _remove(plan.parts)


def prepare(grid: Grid, out: Path, *, resume: bool, overwrite: bool) -> Plan:
    """Everything that can be refused, before the work: writes the plan into the folder of parts."""
    if out.suffix not in (".nc", ".zarr"):
        raise InputError(f"the output is {out}: its name must end in .nc (netCDF) or .zarr")
    if resume and overwrite:
        raise InputError("--resume keeps what there is and --overwrite removes it: give one of them")
    require("h5netcdf", "sweep")
    if out.suffix == ".zarr":
        require("zarr", "sweep")
    plan = Plan(grid, out, provenance(grid))
    found = _found(plan)
    if found is not None and not (resume or overwrite):
        raise InputError(
            f"{out} exists, whole or in parts: give --resume to go on with it or --overwrite to begin anew"
        )
    _require_own(plan)
    if found is not None and resume:
        _require_same(plan, found)
    elif overwrite:
        for path in (out, plan.parts):
            _remove(path)
    if found is None:  # blocks without a plan may be another grid's: what removed them was killed
        for part in plan.parts.glob("*.npz"):
            part.unlink()
    if out.suffix == ".nc" or not out.exists():
        require_writable(out, _expected_size(grid))
    if not out.exists():
        plan.parts.mkdir(exist_ok=True)
        with replacing(plan.parts / "plan.json") as temporary:
            temporary.write_text(json.dumps(plan.provenance, indent=1), encoding="utf-8")
    return plan


def _remove(path: Path) -> None:
    """A file or a folder, which goes from its place whole: half a folder would look like what it was."""
    scratch = path.with_name(path.name + ".removed")
    if scratch.exists():  # an earlier removal was cut off
        shutil.rmtree(scratch)
    if path.is_dir():
        path.rename(scratch)
        shutil.rmtree(scratch)
    else:
        path.unlink(missing_ok=True)


def provenance(grid: Grid) -> dict[str, str]:
    """What decides the numbers: program, rod, emitted code, accuracy, the grid and how it is cut."""
    return {
        "program": f"rodwnl {__version__}",
        "rod": Path(grid.model).name,
        "emitted_code": kernels.fingerprint(grid.model),
        "accuracy": repr(ACCURACY),
        "grid": grid.description,
        "rods_per_block": str(BLOCK),
        "variables": ", ".join(VARIABLES),
    }


def _found(plan: Plan) -> dict[str, str] | None:
    """The provenance of an output, or of parts of one, that exists already."""
    text = plan.parts / "plan.json"
    try:
        if plan.out.exists():
            return _attributes(plan.out)
        return dict(json.loads(text.read_text(encoding="utf-8"))) if text.exists() else None
    except (OSError, ValueError, KeyError, AttributeError):
        return {}


def _attributes(path: Path) -> dict[str, str]:
    if path.suffix != ".zarr":
        return file_attributes(path)
    group = require("zarr", "sweep").open_group(path, mode="r")
    return {name: str(value) for name, value in group.attrs.items()}


def _require_own(plan: Plan) -> None:
    """What --overwrite would remove, and what is removed in the end, must come from a sweep.

    Raises InputError for another file or folder in the place of the output, and for a folder of parts that
    holds what no sweep puts there.
    """
    if plan.out.exists() and not {"program", "grid"} <= (_found(plan) or {}).keys():
        raise InputError(
            f"{plan.out} is in the way: it was not written by rodwnl sweep, or it is damaged; move it "
            "away or choose another name"
        )
    if not plan.parts.exists():
        return
    if not plan.parts.is_dir():
        raise InputError(f"{plan.parts} is in the way: it is no folder; move it away")
    for path in plan.parts.iterdir():
        if not PART.fullmatch(path.name):
            raise InputError(f"{path} is in the way: it was not written by rodwnl sweep; move it away")


def _require_same(plan: Plan, found: dict[str, str]) -> None:
    if not found:
        raise InputError(
            f"{plan.out} cannot be resumed: it was not written by rodwnl sweep, or it is damaged"
        )
    for name, value in plan.provenance.items():
        if found.get(name) != value:
            raise InputError(
                f"{plan.out} cannot be resumed: its {name.replace('_', ' ')} differs, "
                f"there {found.get(name)}, here {value}; give --overwrite to begin anew"
            )


def _expected_size(grid: Grid) -> int:
    per_rod = sum(
        np.dtype(kind).itemsize * (MOST if name not in PER_ROD else 1)
        for name, (kind, *_) in VARIABLES.items()
    )
    return 2 * grid.size * per_rod


def _size(block: Block) -> int:
    return int(np.prod(block.shape))


# ---- the file


def _attributes_of(name: str) -> dict[str, Any]:
    _, unit, text = VARIABLES[name]
    if name != "status":
        return {"long_name": text, "units": unit}
    meanings = " ".join(status.name.lower() for status in Status)
    flags = np.array([*Status], dtype="i1")
    return {"long_name": text, "units": unit, "flag_values": flags, "flag_meanings": meanings}


def _loaded(plan: Plan) -> Iterator[tuple[Block, Values]]:
    for number, block in enumerate(plan.blocks):
        with np.load(plan.part(number)) as values:
            yield block, dict(values)


def _failures(plan: Plan, block: Block, values: Values) -> Iterator[tuple[str, str]]:
    for flat, why in json.loads(str(values["reasons"])).items():
        rod = {name: x.ravel()[int(flat)] for name, x in plan.grid.rods(block).items()}
        yield ", ".join(f"{name} = {x:.17g}" for name, x in rod.items()), why


def _coordinates(grid: Grid) -> Iterator[tuple[str, tuple[str, ...], Real, dict[str, str]]]:
    for name, values in grid.values.items():
        unit, text = PARAMETERS.get(name, ("1", f"parameter of the rod {Path(grid.model).name}"))
        dims = () if values.ndim == 0 else ((name if name in grid.dims else "rod"),)
        yield name, dims, values, {"long_name": text, "units": unit}


def _title(plan: Plan) -> dict[str, str]:
    return {"title": "Hopf thresholds and Landau coefficients of rods"} | plan.provenance


def _to_netcdf(plan: Plan) -> None:
    """Block by block, so that memory holds one of them."""
    h5netcdf = require("h5netcdf", "sweep")
    grid, chunk = plan.grid, plan.grid.block_shape(BLOCK)
    temporary = plan.parts / "whole.nc"
    with h5netcdf.File(temporary, "w") as file:
        file.attrs.update(_title(plan))
        file.dimensions = dict(zip(grid.dims, grid.shape, strict=True)) | {"threshold": MOST}
        for name, dims, numbers, attributes in _coordinates(grid):
            file.create_variable(name, dims, data=numbers).attrs.update(attributes)
        for name, (kind, *_) in VARIABLES.items():
            own = () if name in PER_ROD else (MOST,)
            variable = file.create_variable(
                name, grid.dims + (("threshold",) if own else ()), kind, chunks=(*chunk, *own),
                compression="gzip", compression_opts=1, shuffle=True,
                fillvalue=np.nan if kind == "f8" else None,
            )  # fmt: skip
            variable.attrs.update(_attributes_of(name))
            if grid.dims == ("rod",):
                variable.attrs["coordinates"] = " ".join(grid.values)
        file.attrs["failures"] = _fill(file, plan)
    temporary.replace(plan.out.resolve())


def _fill(target: Any, plan: Plan) -> str:
    """Write all blocks into the variables of an open file; returns the first reasons of failures, as JSON."""
    failures: list[tuple[str, str]] = []
    for block, values in _loaded(plan):
        for name in VARIABLES:
            target[name][block.slices] = values[name]
        failures += islice(_failures(plan, block, values), MOST_REASONS - len(failures))
    return json.dumps(dict(failures))


def _to_zarr(plan: Plan) -> None:
    zarr = require("zarr", "sweep")
    grid, chunk = plan.grid, plan.grid.block_shape(BLOCK)
    temporary = plan.parts / "whole.zarr"
    shutil.rmtree(temporary, ignore_errors=True)
    root = zarr.open_group(temporary, mode="w", zarr_format=2)
    for name, dims, numbers, attributes in _coordinates(grid):
        array = root.create_array(name, data=np.asarray(numbers))
        array.attrs.update(attributes | {"_ARRAY_DIMENSIONS": list(dims)})
    for name, (kind, *_) in VARIABLES.items():
        own = () if name in PER_ROD else (MOST,)
        array = root.create_array(
            name, shape=(*grid.shape, *own), chunks=(*chunk, *own), dtype=kind,
            fill_value=np.nan if kind == "f8" else None,
        )  # fmt: skip
        plain = {k: v.tolist() if isinstance(v, np.ndarray) else v for k, v in _attributes_of(name).items()}
        array.attrs.update(plain | {"_ARRAY_DIMENSIONS": [*grid.dims, *(["threshold"] if own else [])]})
        if grid.dims == ("rod",):
            array.attrs["coordinates"] = " ".join(grid.values)
    root.attrs.update(_title(plan) | {"failures": _fill(root, plan)})
    zarr.consolidate_metadata(temporary)
    temporary.rename(plan.out)
