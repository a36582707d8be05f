"""Results on disk: netCDF through xarray and h5netcdf, described in the file itself, never half a file.

A file is written beside its name under another one and put in place by one rename.
"""

from __future__ import annotations

import os
import shutil
import tempfile
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal

from rodwnl.errors import InputError

if TYPE_CHECKING:
    import xarray

ENGINE: Literal["h5netcdf"] = "h5netcdf"


@contextmanager
def replacing(path: Path) -> Iterator[Path]:
    """A temporary name beside `path`; its file then replaces `path`, unless the body raised.

    Where `path` is a link, it stays one and what it leads to is replaced.
    """
    path = path.resolve()
    _require_replaceable(path)
    handle, name = tempfile.mkstemp(prefix=f".{path.name}.", suffix=path.suffix, dir=path.parent)
    os.close(handle)
    temporary = Path(name)
    try:
        yield temporary
        temporary.chmod(0o666 & ~_umask())  # mkstemp's files are for their owner alone
        temporary.replace(path)
    finally:
        temporary.unlink(missing_ok=True)


def require_writable(path: Path, size: int = 0) -> None:
    """Before a long run: raise InputError unless a file of about `size` bytes can be put at `path`."""
    _require_replaceable(path)
    folder = (path.resolve() if path.is_symlink() else path).parent
    if not folder.is_dir():
        raise InputError(f"cannot write {path}: the folder {folder} does not exist; make it first")
    try:
        with tempfile.NamedTemporaryFile(dir=folder):
            pass
    except OSError as error:
        raise InputError(f"cannot write {path}: {error.strerror}; choose another place") from None
    if (free := shutil.disk_usage(folder).free) < size:
        raise InputError(
            f"cannot write {path}: it needs about {size / 1e6:.0f} MB and {free / 1e6:.0f} MB are free there"
        )


def require_apart(output: Path, *inputs: Path | str | None) -> None:
    """Raise InputError where `output` is a file that the same command reads: writing would destroy it.

    An `output` that is a folder holds what the command names itself, in formats of its own: only an input
    there that ends in .toml cannot be hit.
    """
    for given in inputs:
        if given is None or not Path(given).is_file():
            continue
        hit = output / Path(given).name if output.is_dir() and Path(given).suffix != ".toml" else output
        if hit.exists() and hit.samefile(given):
            raise InputError(f"cannot write {output}: this command reads {given}; choose another place")


def require_new(path: Path, overwrite: bool, ours: Callable[[Path], bool], kind: str) -> None:
    """Refuse to replace `path` unless that was asked for and `ours` says that it is what `kind` names."""
    if not path.exists():
        return
    if not overwrite:
        raise InputError(f"{path} exists: give --overwrite to replace it, or choose another name")
    if not ours(path):
        raise InputError(f"cannot replace {path}: it is not {kind}; move it away or choose another name")


def _require_replaceable(path: Path) -> None:
    """Only a regular file may be replaced: a device or a pipe would be lost."""
    if path.is_dir():
        raise InputError(f"cannot write {path}: it is a folder; name a file in it")
    if path.exists() and not path.is_file():
        raise InputError(f"cannot write {path}: it is not a regular file; choose another name")


def save(dataset: xarray.Dataset, path: Path) -> None:
    """Write a dataset as netCDF 4. Raises OSError where the disk refuses; then nothing stands at `path`."""
    with replacing(path) as temporary:
        dataset.to_netcdf(os.fspath(temporary), engine=ENGINE)


def file_attributes(path: Path) -> dict[str, str]:
    """What a netCDF file says about itself, as texts; nothing where it is none that can be read."""
    try:
        with require("h5netcdf", "simulate").File(path, "r") as file:
            return {name: str(value) for name, value in file.attrs.items()}
    except (OSError, ValueError, KeyError, AttributeError):
        return {}


def load(path: Path) -> xarray.Dataset:
    """A dataset written by `save`, in memory. Raises InputError where the file is missing or is not one."""
    xr: Any = require("xarray", "simulate")
    if not path.is_file():
        raise InputError(f"there is no file {path}")
    try:
        with xr.open_dataset(path, engine=ENGINE) as dataset:
            loaded: xarray.Dataset = dataset.load()
            return loaded
    except (OSError, ValueError, KeyError, RuntimeError):
        raise InputError(
            f"{path} is not a netCDF file that can be read; `rodwnl simulate --out` writes one"
        ) from None


def require(module: str, extra: str) -> Any:
    """Import an optional dependency, or say which extra brings it."""
    from importlib import import_module

    try:
        return import_module(module)
    except ImportError:
        raise InputError(f"this needs {module}: pip install 'rodwnl[{extra}]'") from None


def _umask() -> int:
    mask = os.umask(0)
    os.umask(mask)
    return mask
