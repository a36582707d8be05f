"""Who may import whom: derivation writes generated, rodwnl reads it; the independent route stands alone."""

import ast
import re
from functools import cache
from pathlib import Path

import pytest

import rodwnl

ROOT = Path(rodwnl.__file__).resolve().parent.parent
MODULES = {
    ".".join(path.relative_to(ROOT).with_suffix("").parts).removesuffix(".__init__"): path
    for package in ("derivation", "generated", "rodwnl")
    for path in (ROOT / package).rglob("*.py")
}
DERIVING = {"rodwnl.commands.derive", "rodwnl.commands.export", "rodwnl.commands.verify", "rodwnl.models"}
VERIFYING = {"rodwnl.verification", "rodwnl.effects", "rodwnl.ledgerpage"}  # what `verify` alone imports


@cache
def imported(module, anywhere=True):
    """Dotted names that a module imports: anywhere in it, or at its top level only."""
    tree = ast.parse(MODULES[module].read_text(encoding="utf-8"))
    names = set()
    for node in ast.walk(tree) if anywhere else tree.body:
        if isinstance(node, ast.Import):
            names |= {alias.name for alias in node.names}
        elif isinstance(node, ast.ImportFrom):
            assert node.level == 0, f"{module}: relative import"
            names.add(node.module)
            names |= {f"{node.module}.{alias.name}" for alias in node.names}
    return names


def constants(module, type_):
    tree = ast.parse(MODULES[module].read_text(encoding="utf-8"))
    values = (node.value for node in ast.walk(tree) if isinstance(node, ast.Constant))
    return [value for value in values if isinstance(value, type_)]


def packages(module, anywhere=True):
    return {name.partition(".")[0] for name in imported(module, anywhere)}


def within(package):
    return [name for name in MODULES if name.partition(".")[0] == package]


def reachable(module):
    """The project's modules that importing one leads to."""
    seen, todo = set(), [module]
    while todo:
        for name in imported(todo.pop()) & MODULES.keys():
            if name not in seen:
                seen.add(name)
                todo.append(name)
    return seen


@pytest.mark.parametrize("module", within("derivation"))
def test_the_derivation_is_exact_and_knows_nothing_of_the_rest(module):
    assert not packages(module) & {"rodwnl", "generated", "numpy", "scipy", "mpmath"}
    assert constants(module, float) == []


@pytest.mark.parametrize("module", within("generated"))
def test_emitted_modules_import_nothing(module):
    assert imported(module) == set()


@pytest.mark.parametrize("module", within("rodwnl"))
def test_the_numerics_do_no_symbolic_work(module):
    names = packages(module)
    assert not names & {"sympy", "generated"}
    if module in VERIFYING:
        return
    assert module in DERIVING or "derivation" not in names
    assert "derivation" not in packages(module, anywhere=False)
    assert not VERIFYING & imported(module, anywhere=False)


def test_only_the_kernels_know_the_emitted_package_by_name():
    named = {m for m in within("rodwnl") for text in constants(m, str) if re.match(r"generated(\.|$)", text)}
    assert named == {"rodwnl.kernels"}


def test_the_independent_route_shares_nothing_with_the_expansion():
    assert not reachable("rodwnl.normalform") & {"rodwnl.kernels", "rodwnl.spectrum", "rodwnl.modes"}


def test_no_module_bears_the_name_of_a_public_one():
    modules = {name.rpartition(".")[2] for name in within("rodwnl") if name.count(".") == 1}
    assert not modules & set(rodwnl.__all__)
