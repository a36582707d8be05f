"""The emitted functions in other languages: compiled, run or interpreted, they give what Python does."""

from __future__ import annotations

import ctypes
import json
import re
import shutil
import subprocess
import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import sympy

from derivation.emit.lower import EmissionError
from derivation.emit.nodes import Integer
from derivation.emit.printers import python
from derivation.emit.printers.language import JAX, JULIA, MATHEMATICA, C, source
from derivation.emit.printers.notation import expression
from derivation.emit.program import Argument, Function, Module, Package, compile_function
from derivation.modules import package
from derivation.pipeline import derive

RNG = np.random.default_rng
x, y, k = sympy.symbols("x y k")


@pytest.fixture(scope="module")
def rod() -> Package:
    return package(derive(order=5))


@pytest.fixture(scope="module")
def programs(rod):
    return [compile_function(f) for module in rod.modules for f in module.functions]


@pytest.fixture(scope="module")
def reference(rod, programs):
    """Name -> (arguments, results) of every function at random complex arguments, from the emitted Python."""
    scope: dict[str, object] = {}
    for module in rod.modules:
        exec(python.module(module, rod.model), scope)
    rng, found = RNG(5), {}
    for program in programs:
        # Sixteenths, which every language reads exactly.
        real, imaginary = rng.integers([[8], [-16]], [[32], [17]], (2, len(program.arguments)))
        values = (real + 1j * imaginary) / 16
        results = scope[program.name](*[np] * program.namespace, *values)
        several = results if isinstance(results, tuple) else (results,)
        found[program.name] = [complex(v) for v in values], [complex(r) for r in several]
    return found


def agree(name, results, wanted):
    """To round-off: the sums here lose no more than two digits."""
    assert results == pytest.approx(wanted, rel=1e-13, abs=1e-13), name


def toy(name: str = "f", argument: str = "x", doc: str = "A formula.", expr: sympy.Expr = x * k) -> Package:
    first = Argument(argument, x, "a field")
    function = Function(name, doc, (), (first, Argument("k", k, "a constant")), (("p", expr),))
    return Package("toy", doc, (Module("one", "One.", (function,)),))


# C: compiled with every warning an error, called through a shim that passes arrays.

gcc = pytest.mark.skipif(shutil.which("gcc") is None, reason="gcc is not installed")
FLAGS = ("-std=c99", "-Wall", "-Wextra", "-Wpedantic", "-Werror", "-shared", "-fPIC")


def shim(program, model, number):
    inputs = [f"a[{i}]" for i in range(len(program.arguments))]
    if len(program.outputs) == 1:
        call = f"r[0] = {model}_{program.name}({', '.join(inputs)});"
    else:
        results = [f"r + {i}" for i in range(len(program.outputs))]
        call = f"{model}_{program.name}({', '.join(inputs + results)});"
    return f"void call_{program.name}(const {number} *a, {number} *r) {{ (void)a; {call} }}"


def compiled(folder, text, programs, model, number):
    (folder / f"{model}.h").write_text(text)
    lines = [f"#define RODWNL_NUMBER {number}", f'#include "{model}.h"']
    (folder / "shim.c").write_text("\n".join([*lines, *(shim(p, model, number) for p in programs), ""]))
    subprocess.run(["gcc", *FLAGS, "shim.c", "-o", "shim.so"], cwd=folder, check=True)
    return ctypes.CDLL(str(folder / "shim.so"))


def called(library, name, values, count, kind):
    given, results = np.array(values, kind), np.full(count, np.nan, kind)
    pointer = ctypes.c_void_p
    library[f"call_{name}"](given.ctypes.data_as(pointer), results.ctypes.data_as(pointer))
    return results.tolist()


@gcc
def test_c_compiles_and_agrees(rod, programs, reference, tmp_path):
    library = compiled(tmp_path, source(rod, C), programs, rod.model, "double complex")
    for name, (values, wanted) in reference.items():
        agree(name, called(library, name, values, len(wanted), complex), wanted)


@gcc
def test_c_on_real_numbers(rod, programs, tmp_path):
    real = [
        p for p in programs if p.name in ("right_hand_side", "strains", "tip_amplitude_squared", "base_state")
    ]
    library = compiled(tmp_path, source(rod, C), real, rod.model, "double")
    scope: dict[str, object] = {}
    for module in rod.modules:
        exec(python.module(module, rod.model), scope)
    for program in real:
        values = RNG(2).uniform(0.5, 2, len(program.arguments))
        wanted = scope[program.name](*[np] * program.namespace, *values)
        found = called(library, program.name, values, len(program.outputs), float)
        agree(program.name, found, np.atleast_1d(wanted).tolist())


@gcc
def test_c_as_a_library_of_its_own(tmp_path):
    (tmp_path / "rod.h").write_text(source(toy(), C))
    subprocess.run(
        ["gcc", *FLAGS, "-DRODWNL_API=", "-x", "c", "rod.h", "-o", "rod.so"], cwd=tmp_path, check=True
    )
    assert hasattr(ctypes.CDLL(str(tmp_path / "rod.so")), "toy_f")


@gcc
def test_c_powers_of_sums(tmp_path):
    powers = toy(expr=(x + k) ** 5 + x**3)
    program = compile_function(powers.modules[0].functions[0])
    library = compiled(tmp_path, source(powers, C), [program], "toy", "double complex")
    assert called(library, "f", [2j, 1], 1, complex) == [pytest.approx((1 + 2j) ** 5 + (2j) ** 3)]


# JAX


@pytest.fixture(scope="module")
def jax_scope(rod):
    jax = pytest.importorskip("jax", reason="jax is not installed: pip install 'rodwnl[jax]'")
    jax.config.update("jax_enable_x64", True)
    scope: dict[str, object] = {}
    exec(source(rod, JAX), scope)
    return scope


def test_jax_compiles_and_agrees(reference, jax_scope):
    given = {name: values for name, (values, _) in reference.items()}
    # All in one compilation, which takes a fraction of the time of a hundred.
    everything = jax_scope["jax"].jit(lambda g: {name: jax_scope[name](*v) for name, v in g.items()})
    for name, results in everything(given).items():
        several = results if isinstance(results, tuple) else (results,)
        agree(name, [complex(r) for r in several], reference[name][1])


def test_jax_maps_and_differentiates(jax_scope):
    jax, g3 = jax_scope["jax"], jax_scope["g3"]
    assert hasattr(g3, "lower")  # only what is compiled can be lowered
    values = RNG(3).normal(size=(8, 4)) + 1j
    mapped = jax.vmap(g3)(*values)
    assert np.allclose(mapped, [g3(*column) for column in values.T], rtol=1e-14)
    slope = jax.jacfwd(jax_scope["base_state"], argnums=2)(50.0, 20.0, 7.0)
    assert slope == pytest.approx((-1 / 50, 1 - 20 / 50), rel=1e-14)  # nu = 1 - F/k1, mu = k2 nu + F


# Julia: parsed by its own grammar, then evaluated from the tree.


@pytest.fixture(scope="module")
def julia():
    reason = "tree-sitter-julia is not installed: pip install 'rodwnl[test]'"
    sitter = pytest.importorskip("tree_sitter", reason=reason)
    grammar = pytest.importorskip("tree_sitter_julia", reason=reason)
    return sitter.Parser(sitter.Language(grammar.language()))


OPERATORS = {
    "+": lambda a, b: a + b,
    "-": lambda a, b: a - b,
    "*": lambda a, b: a * b,
    "/": lambda a, b: a / b,
    "^": lambda a, b: a**b,
}
# A sign before a bracket is a call of the operator.
JULIA_FUNCTIONS = {
    "-": np.negative,
    "conj": np.conj,
    "sin": np.sin,
    "cos": np.cos,
    "exp": np.exp,
    "sqrt": np.sqrt,
}


def evaluated(node, values):
    parts = node.named_children
    match node.type:
        case "identifier":
            return 1j if node.text == b"im" else values[node.text.decode()]
        case "integer_literal":
            return int(node.text)
        case "parenthesized_expression":
            return evaluated(parts[0], values)
        case "unary_expression":
            assert parts[0].text == b"-"
            return -evaluated(parts[1], values)
        case "binary_expression":
            left, operator, right = parts
            return OPERATORS[operator.text.decode()](evaluated(left, values), evaluated(right, values))
        case "call_expression":
            name, arguments = parts
            return JULIA_FUNCTIONS[name.text.decode()](evaluated(arguments.named_children[0], values))
        case "open_tuple":
            return [evaluated(part, values) for part in parts]
    raise AssertionError(f"{node.type} in {node.text.decode()}")


def applied(function, given):
    """The value of a Julia function, its statements taken one after the other."""
    signature, *statements = function.named_children
    name, arguments = signature.named_children[0].named_children
    values = dict(zip((a.text.decode() for a in arguments.named_children), given, strict=True))
    for statement in statements:
        parts = statement.named_children
        if statement.type == "return_statement":
            result = evaluated(parts[0], values)
            return name.text.decode(), result if isinstance(result, list) else [result]
        assert statement.type == "assignment"
        values[parts[0].text.decode()] = evaluated(parts[-1], values)
    raise AssertionError(f"{name.text.decode()} returns nothing")


def found(node, kind):
    return [n for child in node.children for n in ([child] if child.type == kind else found(child, kind))]


def test_julia_parses_and_agrees(rod, programs, reference, julia):
    tree = julia.parse(source(rod, JULIA).encode())
    assert not tree.root_node.has_error
    exported = [n.text.decode() for s in found(tree.root_node, "export_statement") for n in s.named_children]
    functions = found(tree.root_node, "function_definition")
    assert exported == [program.name for program in programs]
    assert len(functions) == len(programs)
    for program, function in zip(programs, functions, strict=True):
        values, wanted = reference[program.name]
        name, results = applied(function, values)
        assert name == program.name
        agree(name, [complex(r) for r in results], wanted)


def test_julia_texts_are_harmless(julia):
    tree = julia.parse(source(toy(doc='A "cost" of $5, or \\$(run())'), JULIA).encode())
    assert not tree.root_node.has_error
    assert not found(tree.root_node, "string_interpolation")


# Mathematica: run by Mathics in a process of its own.

MATHICS = """
import json, sys
from mathics.core.load_builtin import import_and_load_builtins
from mathics.session import MathicsSession
import_and_load_builtins()
session = MathicsSession(add_builtin=True, catch_interrupt=False)
path, calls = json.load(sys.stdin)
session.evaluate(f'<< "{path}"')
texts = [session.evaluate(f"ToString[InputForm[N[Flatten[{{{call}}}]]]]").to_python() for call in calls]
sys.stdout.write("RESULT" + json.dumps(texts))
"""


def numbers(text):
    """{1. + 2.*I, 3.*^-5} as Python's complex numbers."""
    parts = text.strip('"{}').replace("*^", "e").replace("*I", "j").replace(" ", "").split(",")
    return [complex(part) for part in parts]


def test_mathematica_runs_and_agrees(rod, reference, tmp_path):
    pytest.importorskip("mathics.version", reason="Mathics3 is not installed: pip install 'rodwnl[test]'")
    path = tmp_path / "rod.wl"
    path.write_text(source(rod, MATHEMATICA))
    # Every module is covered; exact arithmetic on all functions would take too long.
    names = [f.name for module in rod.modules for f in module.functions[::4]]
    calls = []
    for name in names:
        given = (f"({round(16 * v.real)} + {round(16 * v.imag)} I)/16" for v in reference[name][0])
        calls.append(f"{MATHEMATICA.spell(name)}[{', '.join(given)}]")
    done = subprocess.run(
        [sys.executable, "-c", MATHICS],
        input=json.dumps([str(path), calls]),
        capture_output=True,
        text=True,
        check=True,
    )
    for name, text in zip(names, json.loads(done.stdout.partition("RESULT")[2]), strict=True):
        agree(name, numbers(text), reference[name][1])


def test_mathematica_names_are_its_users():
    text = source(toy(argument="Theta_bar_u", name="N"), MATHEMATICA)
    assert "n[thetaBarU_, k_] := Module[{}," in text
    assert "_" not in re.sub(r'".*?"|[a-zA-Z0-9]+_[,\]]', "", text.split("Private`")[1], flags=re.S)


# What cannot be written in a language is refused.


@pytest.mark.parametrize(
    ("language", "argument"), [(C, "double"), (C, "I"), (JULIA, "end"), (JULIA, "im"), (JAX, "jnp")]
)
def test_reserved_words(language, argument):
    with pytest.raises(EmissionError, match=f"{argument!r} means something else in {language.name}"):
        source(toy(argument=argument), language)


def test_names_that_become_one():
    two = Function("f", "A.", (), (Argument("Y", x, "a"), Argument("y", y, "b")), (("p", x * y),))
    package = Package("toy", "A toy.", (Module("one", "One.", (two,)),))
    assert "f(Y, y)" in source(package, JULIA)
    with pytest.raises(EmissionError, match="f: two names become y"):
        source(package, MATHEMATICA)


def test_c_comments_stay_comments():
    text = source(toy(doc="Ends */ here /* or not."), C)
    assert text.count("/*") == text.count("*/")
    assert "Ends * / here / * or not." in text


@pytest.mark.parametrize("language", [C, JULIA, MATHEMATICA, JAX])
def test_lines_fit(rod, language):
    lines = source(rod, language).splitlines()
    assert max(map(len, lines)) <= 150  # a name and two short lists may share a line


def test_a_language_is_its_table():
    """Another notation in the table is all that another spelling takes."""
    shouting = replace(JULIA, notation=replace(JULIA.notation, name=str.upper))
    assert "K * X" in source(toy(), shouting)
    assert Path(python.__file__).parent.name == "printers"


def test_whole_numbers_that_c_cannot_hold_are_written_as_doubles():
    assert expression(Integer(12), C.notation) == "12"
    assert expression(Integer(30_000_000_000_000_000_000), C.notation) == "30000000000000000000.0"
