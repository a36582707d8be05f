"""Files: the same bytes every time, atomic replacement, a diff for every way in which a folder can differ."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest
import sympy

from derivation.emit import write as emit_write
from derivation.emit.lower import EmissionError
from derivation.emit.program import Argument, Function, Module, Package
from derivation.emit.write import difference, render, write

x, y, k = sympy.symbols("x y k")
ARGUMENTS = (
    Argument("x", x, "a field", "(...)"),
    Argument("y", y, "a field", "(...)"),
    Argument("k", k, "a constant", "(...)"),
)


def package(factor: int = 1, model: str = "toy", name: str = "f") -> Package:
    first = Function(name, "A formula.", (), ARGUMENTS, (("p", factor * x * y / k),))
    second = Function("g", "Another.", (), ARGUMENTS, (("p", x - y), ("q", (x - y) / k)))
    return Package(model, "A toy.", (Module("one", "One.", (first,)), Module("two", "Two.", (second,))))


# Renders a formula whose terms are gathered through sets and a polynomial ring, where order could leak in.
SCRIPT = """
import sympy
from derivation.emit.program import Argument, Function, Module, Package
from derivation.emit.write import render
names = ["Y", "Theta", "H", "P0", "P2", "k1", "k2", "force"]
symbols = sympy.symbols(names)
ring = sympy.ring(names, sympy.QQ_I)[0]
generators = [ring.from_expr(sympy.Symbol(name)) for name in set(names)]
expr = (sum(generators) ** 3 / 6 + sum(g**2 for g in set(generators))).as_expr() + sympy.I * symbols[0]
extra = sum({s / (symbols[5] - symbols[6]) for s in symbols}) * (1 - symbols[6] / symbols[5])
extra += sympy.conjugate(symbols[0])
arguments = tuple(Argument(s.name, s, "a field", "(...)") for s in symbols)
function = Function("f", "A formula.", (), arguments, (("p", expr), ("q", extra * expr), ("r", extra)))
print(sympy.external.gmpy.GROUND_TYPES)
print(render(Package("toy", "A toy.", (Module("one", "One.", (function,)),))))
"""


def test_same_bytes_whatever_the_hash_seed_and_the_ground_types():
    outputs = {}
    for seed, ground in (("0", "python"), ("1", "flint"), ("2", "python"), ("3", "flint")):
        settings = {
            "PYTHONHASHSEED": seed,
            "SYMPY_GROUND_TYPES": ground,
            "PYTHONPATH": os.pathsep.join(sys.path),
        }
        done = subprocess.run(
            [sys.executable, "-c", SCRIPT],
            env=os.environ | settings,
            capture_output=True,
            text=True,
            check=True,
        )
        used, outputs[seed] = done.stdout.split("\n", 1)
        assert used == ground
    assert len(outputs["0"]) > 1000
    assert len(set(outputs.values())) == 1


def test_header_and_file_list():
    files = render(package())
    assert sorted(files) == ["__init__.py", "toy/__init__.py", "toy/one.py", "toy/two.py"]
    for path, text in files.items():
        assert text.startswith(emit_write.MARK), path
        assert "Never edit" in text.split("\n")[0]
        assert text.endswith("\n")
        assert not text.endswith("\n\n")
        compile(text, path, "exec")
    assert files == render(package())


def test_fingerprint_changes_with_the_mathematics_only():
    def stamp(files: dict[str, str]) -> str:
        return next(line for line in files["toy/__init__.py"].split("\n") if line.startswith("FINGERPRINT"))

    assert stamp(render(package())) == stamp(render(package(), package(model="other")))
    assert stamp(render(package())) != stamp(render(package(factor=2)))


def test_a_written_folder_agrees_and_is_not_written_again(tmp_path):
    files = render(package())
    assert write(files, tmp_path) == sorted(files)
    assert difference(files, tmp_path) == ""
    assert write(files, tmp_path) == []
    assert sorted(p.relative_to(tmp_path).as_posix() for p in tmp_path.rglob("*.*")) == sorted(files)


def test_caches_are_not_surplus(tmp_path):
    write(render(package()), tmp_path)
    (tmp_path / "toy/__pycache__").mkdir()
    (tmp_path / "toy/__pycache__/one.cpython-311.pyc").write_bytes(b"\0")
    assert difference(render(package()), tmp_path) == ""


def test_a_changed_file_is_shown_and_mended(tmp_path):
    files = render(package())
    write(files, tmp_path)
    path = tmp_path / "toy/one.py"
    path.write_text(files["toy/one.py"].replace("x*y/k", "x*y*k"))
    shown = difference(files, tmp_path)
    assert "--- a/toy/one.py\n+++ b/toy/one.py\n" in shown
    assert "-    return x*y*k\n+    return x*y/k\n" in shown
    assert shown.count("--- ") == 1
    assert write(files, tmp_path) == ["toy/one.py"]
    assert difference(files, tmp_path) == ""


@pytest.mark.parametrize(
    "change", [lambda t: t.replace("\n", "\r\n"), lambda t: t.rstrip("\n"), lambda t: t + "\n"]
)
def test_invisible_changes_are_shown(tmp_path, change):
    files = render(package())
    write(files, tmp_path)
    (tmp_path / "toy/two.py").write_bytes(change(files["toy/two.py"]).encode())
    assert "+++ b/toy/two.py" in difference(files, tmp_path)


def test_a_missing_file_is_shown(tmp_path):
    files = render(package())
    write(files, tmp_path)
    (tmp_path / "toy/two.py").unlink()
    shown = difference(files, tmp_path)
    assert shown.startswith("--- /dev/null\n+++ b/toy/two.py\n@@ ")
    assert "+def g(x, y, k):\n" in shown


def test_a_missing_folder_is_all_missing(tmp_path):
    assert difference(render(package()), tmp_path / "nowhere").count("--- /dev/null\n") == 4


@pytest.mark.parametrize(
    "path", ["stray.py", "toy/stray.py", "toy/notes.txt", "toy/empty.py", "other/stray.py"]
)
def test_a_surplus_file_is_shown_and_a_strangers_kept(tmp_path, path):
    files = render(package())
    write(files, tmp_path)
    (tmp_path / path).parent.mkdir(exist_ok=True)
    (tmp_path / path).write_text("" if "empty" in path else "text\n")
    assert difference(files, tmp_path).startswith(f"--- a/{path}\n+++ /dev/null\n")
    write(files, tmp_path)
    assert (tmp_path / path).exists()


def test_other_rods_are_surplus_only_where_the_folder_is_to_hold_one(tmp_path):
    write(render(package(model="other")), tmp_path)
    write(render(package()), tmp_path)
    assert "a/other/one.py" in difference(render(package()), tmp_path)
    assert difference(render(package()), tmp_path, alone=False) == ""
    assert difference(render(package(), package(model="other")), tmp_path) == ""


def test_a_module_that_is_no_longer_emitted_is_removed(tmp_path):
    write(render(package()), tmp_path)
    fewer = render(Package("toy", "A toy.", package().modules[:1]))
    assert write(fewer, tmp_path) == ["toy/__init__.py", "toy/two.py"]
    assert difference(fewer, tmp_path) == ""


def test_a_crash_leaves_whole_files_and_an_old_fingerprint(tmp_path, monkeypatch):
    old, new = render(package()), render(package(factor=2))
    write(old, tmp_path)

    def failing(source: Path, target: Path) -> None:
        raise OSError("disk full")

    monkeypatch.setattr(emit_write.os, "replace", failing)
    with pytest.raises(OSError, match="disk full"):
        write(new, tmp_path)
    monkeypatch.undo()
    assert difference(old, tmp_path) == ""
    assert not list(tmp_path.rglob(".*"))

    replaced = []
    real = os.replace
    monkeypatch.setattr(emit_write.os, "replace", lambda s, t: (replaced.append(Path(t).name), real(s, t)))
    write(new, tmp_path)
    assert replaced == ["one.py", "__init__.py"]


@pytest.mark.parametrize(
    ("bad", "message"),
    [
        (package(model="../evil"), "'../evil' is not a name"),
        (package(model="class"), "'class' is not a name"),
        (package(name="g"), "toy: the name 'g' is defined twice"),
    ],
)
def test_refused_packages(bad, message):
    with pytest.raises(EmissionError, match=message):
        render(bad)
