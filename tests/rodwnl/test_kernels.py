"""The importer of `generated` takes what the derivation wrote and refuses all else, naming the place."""

from __future__ import annotations

import importlib
import sys

import pytest
import sympy

from derivation.emit.program import Argument, Function, Module, Package
from derivation.emit.write import MARK, render, write
from rodwnl import kernels
from rodwnl.errors import InputError

x = sympy.Symbol("x")
TOY = Package(
    "toy",
    "A toy.",
    (
        Module(
            "one",
            "One.",
            (Function("half", "x/2.", (), (Argument("x", x, "a field", "(...)"),), (("y", x / 2),)),),
        ),
    ),
)


@pytest.fixture
def folder(tmp_path, monkeypatch):
    """A folder `generated` that hides the project's own, and no memory of it before or after."""

    def forget():
        for name in [n for n in sys.modules if n.split(".")[0] == "generated"]:
            monkeypatch.delitem(sys.modules, name)
        kernels.load.cache_clear()
        importlib.invalidate_caches()

    forget()
    monkeypatch.syspath_prepend(tmp_path)
    write(render(TOY), tmp_path / "generated")
    yield tmp_path / "generated"
    forget()


def test_accepts_what_the_derivation_wrote(folder):
    assert kernels.load("toy").half(3.0) == 1.5
    assert kernels.MARK == MARK
    assert kernels.location() == folder


def test_line_ends_do_not_matter(folder):
    for path in folder.rglob("*.py"):
        path.write_bytes(path.read_bytes().replace(b"\n", b"\r\n"))
    assert kernels.load("toy").half(3.0) == 1.5


def test_a_strangers_package_is_refused_and_not_run(folder):
    (folder / "__init__.py").write_text("raise SystemExit('a stranger ran')\n")
    with pytest.raises(
        InputError, match=r"another package called 'generated' in .*generated before rodwnl's own"
    ):
        kernels.load("toy")
    with pytest.raises(InputError, match="another package"):
        kernels.source_folder()


def test_a_strangers_folder_without_init_is_refused(folder, monkeypatch):
    (folder / "__init__.py").unlink()
    monkeypatch.setattr(sys, "path", [str(folder.parent)])
    with pytest.raises(InputError, match="another package called 'generated'"):
        kernels.location()


def test_a_strangers_module_is_refused(tmp_path, monkeypatch):
    (tmp_path / "generated.py").write_text("raise SystemExit('a stranger ran')\n")
    monkeypatch.setattr(sys, "path", [str(tmp_path)])
    for name in [n for n in sys.modules if n.split(".")[0] == "generated"]:
        monkeypatch.delitem(sys.modules, name)
    importlib.invalidate_caches()
    with pytest.raises(InputError, match="another package called 'generated'"):
        kernels.location()


def test_no_package_at_all(tmp_path, monkeypatch):
    monkeypatch.setattr(kernels, "PACKAGE", "no_such_package_anywhere")
    with pytest.raises(
        InputError, match="no package 'no_such_package_anywhere' on Python's path: run `rodwnl derive`"
    ):
        kernels.location()


@pytest.mark.parametrize("damage", ["changed", "missing", "surplus", "unstamped"])
def test_a_damaged_package_is_refused(folder, damage):
    module, init = folder / "toy/one.py", folder / "toy/__init__.py"
    if damage == "changed":
        module.write_text(module.read_text().replace("x/2", "x/3"))
    elif damage == "missing":
        module.unlink()
    elif damage == "surplus":
        (folder / "toy/two.py").write_text("")
    else:
        init.write_text(init.read_text().split("FINGERPRINT")[0])
    with pytest.raises(InputError, match=r"toy is not what the derivation wrote .* run `rodwnl derive`"):
        kernels.load("toy")


def test_an_unknown_rod_lists_the_known(folder):
    with pytest.raises(InputError, match=r"no rod 'elastica' in .* \(only: toy\)"):
        kernels.load("elastica")


def test_the_default_rods_functions_are_attributes(folder, monkeypatch):
    monkeypatch.setattr(kernels, "DEFAULT", "toy")
    assert kernels.half(1.0) == 0.5
    with pytest.raises(AttributeError, match="no emitted function 'third'; there are half"):
        kernels.third  # noqa: B018


def test_derive_rewrites_the_source_tree_only(folder):
    with pytest.raises(
        InputError, match=r"generated is not in a source tree of rodwnl: say where .* --out DIR"
    ):
        kernels.source_folder()
    project = folder.parent / "pyproject.toml"
    project.write_text('[project]\nname = "another"\n')
    with pytest.raises(InputError, match="--out DIR"):
        kernels.source_folder()
    project.write_text("not toml [")
    with pytest.raises(InputError, match="--out DIR"):
        kernels.source_folder()
    project.write_text('[project]\nname = "rodwnl"\n')
    assert kernels.source_folder() == folder
