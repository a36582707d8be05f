"""What `--model` names: a shipped rod, or a file that describes one and is derived when it is first used."""

from __future__ import annotations

import hashlib
import os
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING

from rodwnl import kernels
from rodwnl.errors import InputError

if TYPE_CHECKING:
    from derivation.model import RodModel

SUFFIX = ".toml"


def find_model(text: str) -> RodModel:
    """The model itself: a shipped one by its name, or what a file says. Imports SymPy.

    Raises InputError for a name that is not known and for a file that cannot be read.
    """
    from derivation.errors import ModelError, ReadError
    from derivation.model import MODELS

    if is_file(text):
        from derivation.modelfile import read_model

        try:
            return read_model(_read(Path(text)))
        except (ModelError, ReadError) as error:
            raise InputError(f"{text}: {error}") from None
    name = text.replace("-", "_")
    if name not in MODELS:
        raise InputError(
            f"there is no rod {text!r}; there are {', '.join(MODELS)}, or give a file like rod{SUFFIX}"
        )
    return MODELS[name]


def emitted(text: str) -> str:
    """What `RodParameters` takes as its model: the shipped rod's name, or the folder of the file's rod.

    A file is derived once, into the user's cache. The key is the file's text and the sources that derive and
    emit; SymPy is imported only where nothing is found under it.
    """
    if not is_file(text):
        name = text.replace("-", "_")
        if name not in (known := kernels.emitted_rods()):
            raise InputError(f"there is no rod {text!r}; there are {', '.join(known)}, or give a rod{SUFFIX}")
        kernels.load(name)
        return name
    root = cache_folder() / _key(_read(Path(text)))
    found = [folder for folder in root.glob("[!._]*") if (folder / "__init__.py").is_file()]
    for folder in found:
        try:
            kernels.load(str(folder))
        except InputError:
            continue  # half written or changed: derived again below
        return str(folder)
    return str(_derive(text, root))


def is_file(text: str) -> bool:
    """Whether this names a file and not a shipped rod."""
    return text.endswith(SUFFIX) or Path(text).name != text


def cache_folder() -> Path:
    """Where rods from files are kept; $RODWNL_CACHE overrides the user's cache folder."""
    if own := os.environ.get("RODWNL_CACHE"):
        return Path(own)
    if sys.platform == "win32":
        base = os.environ.get("LOCALAPPDATA") or Path.home() / "AppData" / "Local"
    elif sys.platform == "darwin":
        base = Path.home() / "Library" / "Caches"
    else:
        base = os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache"
    return Path(base) / "rodwnl"


@contextmanager
def refusals(rod: str) -> Iterator[None]:
    """What the derivation or the emission refuse to do with a rod, as InputError."""
    from derivation.emit.lower import EmissionError
    from derivation.errors import ModelError

    try:
        yield
    except ModelError as error:
        raise InputError(f"{rod}: {error}") from None
    except EmissionError as error:
        raise InputError(f"{rod}: {error}; give such a number as a parameter with a default") from None


def _derive(text: str, root: Path) -> Path:
    from derivation.emit.write import render, write
    from derivation.modules import EMITTED_ORDER, package
    from derivation.pipeline import derive

    model = find_model(text)
    with refusals(text):
        files = render(package(derive(model, order=EMITTED_ORDER)))
    root.mkdir(parents=True, exist_ok=True, mode=0o700)
    write(files, root)
    return root / model.name


def _key(text: str) -> str:
    """A hash of the model's text and of every source from which its modules follow."""
    digest = hashlib.sha256(text.encode())
    source = Path(__file__).resolve().parent.parent / "derivation"
    for path in sorted([*source.glob("*.py"), *source.glob("*.lark"), *source.glob("emit/**/*.*")]):
        if "__pycache__" not in path.parts:
            digest.update(f"{path.relative_to(source).as_posix()}\0".encode() + path.read_bytes() + b"\0")
    return digest.hexdigest()[:32]


LONGEST_FILE = 100_000


def _read(path: Path) -> str:
    try:
        with path.open("rb") as file:
            content = file.read(LONGEST_FILE + 1)
    except OSError as error:
        raise InputError(f"{path}: {error.strerror or error}") from None
    if len(content) > LONGEST_FILE:
        raise InputError(f"{path} is longer than {LONGEST_FILE} bytes: it does not describe a rod")
    try:
        return content.decode("utf-8").replace("\r\n", "\n")
    except UnicodeDecodeError:
        raise InputError(f"{path} is not a text in UTF-8") from None
