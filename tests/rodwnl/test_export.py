"""`rodwnl export`: every format comes out whole, the AUTO file is a problem that the computed mode solves."""

from __future__ import annotations

import ctypes
import os
import re
import shutil
import subprocess
from pathlib import Path

import numpy as np
import pytest
from scipy.integrate import solve_bvp

from derivation.catalogue import objects
from derivation.emit.printers.language import C
from derivation.export import FORMATS as SYMBOLIC
from derivation.modelfile import read_model
from derivation.pipeline import derive
from rodwnl import cli
from rodwnl.commands.export import AUTO, FORMATS

LOADED = Path(__file__).parents[2] / "examples" / "loaded.toml"


# Stretch and drag go like powers of the stretch: the problem for AUTO-07p holds exp and log
POWERS = """
name = "powers"
title = "powers"
energy = "k1*(exp(p*log(h1)) - p*log(h1) - 1)/p^2 + k2*h2^2/2 + Pi^2/2"
parameters = { p = { default = "27/10" } }
drag = { v1 = "gamma1", v2 = "exp(0.3*log(h1))", Omega = "gamma3*exp(h1 - 1)" }
load = [{ kind = "follower" }]
"""
ROD = ["--k1", "1e4", "--k2", "1e4", "--gamma3", "1e-4"]
RODS = {
    "follower": ROD,
    "distributed": ["--model", "distributed", *ROD],  # coefficients that vary along the rod
    "quartic": ["--model", "quartic", "--k1", "1e3", "--k2", "1e3", "--gamma3", "1e-3"],  # nu is an unknown
    "loaded": ["--model", str(LOADED), "--k1", "200", "--k2", "100", "--gamma3", "1e-2"],  # nu is a function
    "powers": ["--model", "powers.toml", *ROD],
}


def export(capsys, *arguments):
    code = cli.run(["export", *arguments])
    out, err = capsys.readouterr()
    return code, out, err


def test_the_command_knows_the_formats():
    assert (*SYMBOLIC, AUTO) == FORMATS


@pytest.mark.parametrize("form", SYMBOLIC)
def test_file_and_standard_output_are_the_same(form, tmp_path, capsys):
    code, out, _ = export(capsys, "--format", form, "-")
    assert (code, out.count("\n") > 100) == (0, True)
    assert export(capsys, "--format", form, str(tmp_path / "out"))[:2] == (0, "")
    assert (tmp_path / "out").read_text(encoding="utf-8") == out
    assert [path.name for path in tmp_path.iterdir()] == ["out"]


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["--format", "maple", "-"], "no format 'maple'; there are latex, mathematica, julia, c, jax, auto"),
        (["--format", "c", "--k1", "1", "-"], "--format c holds no numbers: leave out --k1"),
        (["--format", "latex", "--threshold", "2", "-"], "leave out --threshold"),
        (["--format", "julia", "--threshold", "0", "-"], "leave out --threshold"),
        (["--format", "auto", "--k1", "1", "-"], "give --k2, --gamma3 too"),
        (
            ["--format", "auto", *ROD, "--threshold", "9", "-"],
            "there is no Hopf threshold number 9: this rod has",
        ),
        (["--format", "c", "--model", "follwer", "-"], "there is no rod 'follwer'"),
        (["--format", "julia", "/nowhere/rod.jl"], "the folder /nowhere does not exist"),
        (["--format", "julia", "/"], "it is a folder"),
    ],
)
def test_what_is_refused(capsys, arguments, message):
    code, out, err = export(capsys, *arguments)
    assert (code, out, err.count("\n")) == (2, "", 1)
    assert message in err


@pytest.fixture(scope="module")
def ambiguous():
    """A rod whose parameters are words of C, of Julia and of the file for JAX."""
    text = "".join(f'{name} = {{ default = "1" }}\n' for name in ("NULL", "end", "jax"))
    return derive(
        read_model(
            'name = "odd"\nenergy = "k1*(h1 - 1)^2/2 + k2*h2^2/2 + Pi^2/2 + NULL*end*jax*Pi^4"\n'
            f'[parameters]\n{text}[drag]\nv1 = "gamma1"\nv2 = "1"\nOmega = "gamma3"\n'
            '[[load]]\nkind = "follower"\n'
        )
    )


@pytest.mark.parametrize(("form", "word"), [("c", "NULL"), ("julia", "end"), ("jax", "jax")])
def test_a_parameter_that_the_language_reserves(ambiguous, form, word, monkeypatch, capsys):
    monkeypatch.setattr("rodwnl.commands.export._derivation", lambda model: ambiguous)
    code, out, err = export(capsys, "--format", form, "-")
    assert (code, out) == (2, "")
    assert err == f"rodwnl: odd: {word!r} means something else in {form}: choose another name\n"


@pytest.mark.skipif(shutil.which("gcc") is None, reason="gcc is not installed")
@pytest.mark.parametrize("header", ["tgmath.h", "stdio.h", "stdbool.h", "stddef.h"])
def test_no_name_is_a_macro_of_a_standard_header(header):
    """Those that a parameter could bear: without arguments, not with an underscore first."""
    command = ["gcc", "-std=gnu17", "-dM", "-E", "-include", header, "-x", "c", os.devnull]
    macros = subprocess.run(command, check=True, capture_output=True, text=True).stdout
    names = set(re.findall(r"^#define ([A-Za-z]\w*) ", macros, re.MULTILINE)) - {"P_tmpdir", "L_ctermid"}
    assert names
    assert names <= C.reserved, names - C.reserved


def test_powers_leave_for_every_tool(capsys, tmp_path):
    (tmp_path / "powers.toml").write_text(POWERS)
    for form in SYMBOLIC:
        code, out, err = export(capsys, "--format", form, "--model", str(tmp_path / "powers.toml"), "-")
        assert (code, err) == (0, "")
        assert ("Exp[" if form == "mathematica" else "exp") in out


# LaTeX

ALLOWED = re.findall(
    r"\S+",
    """documentclass usepackage title author date begin end maketitle section paragraph texttt label
    allowdisplaybreaks notag left right quad frac int mathrm mathcal operatorname partial cos sin dot tilde
    alpha beta gamma theta Theta nu mu omega Omega Pi Psi Delta lambda tau sigma varphi _ ,""",
)


@pytest.fixture(scope="module")
def document():
    return SYMBOLIC["latex"](derive())


def test_the_document_holds_every_object_in_order(document):
    labels = re.findall(r"\\label\{rod:(\w+)\}", document)
    assert labels == list(objects(derive()))


def test_the_document_needs_amsmath_alone(document):
    assert set(re.findall(r"\\([a-zA-Z]+|[_,])", document)) <= set(ALLOWED)
    assert re.findall(r"\\usepackage.*\{(\w+)\}", document) == ["geometry", "amsmath"]


def test_the_document_parses(document):
    walker = pytest.importorskip("pylatexenc.latexwalker", reason="pylatexenc: pip install 'rodwnl[test]'")
    nodes, position, length = walker.LatexWalker(document, tolerant_parsing=False).get_latex_nodes()
    assert (position, length) == (0, len(document))
    assert any(node.isNodeType(walker.LatexEnvironmentNode) for node in nodes)
    for display in re.findall(r"\\begin\{align\}(.*?)\\end\{align\}", document, re.DOTALL):
        for line in display.split(r"\\"):
            assert line.count("&") == 1
            assert line.count(r"\left") == line.count(r"\right")
            assert line.count("{") == line.count("}")


# AUTO-07p, whose header is stood in for by what it declares

HEADER = "typedef int integer;\ntypedef double doublereal;\n"
FLAGS = ("-std=c99", "-Wall", "-Wextra", "-Wpedantic", "-Werror", "-Wno-unused-parameter", "-O1")
gcc = pytest.mark.skipif(shutil.which("gcc") is None, reason="gcc is not installed")


class Problem:
    """A compiled equations file, called as AUTO calls it, with the numbers of its constants file."""

    def __init__(self, folder, text):
        (folder / "auto_f2c.h").write_text(HEADER)
        (folder / "rod.c").write_text(text)
        command = ["gcc", *FLAGS, "-I.", "-shared", "-fPIC", "rod.c", "-o", "rod.so", "-lm"]
        subprocess.run(command, cwd=folder, check=True)
        self._library = ctypes.CDLL(str(folder / "rod.so"))
        self.ndim, self.nbc = (int(re.search(rf"{name}=(\d+)", text).group(1)) for name in ("NDIM", "NBC"))
        names = re.search(r"parnames=\{(.*)\}", text).group(1)
        self.parameters = re.findall(r"'(\w+)'", names)
        self.free = re.findall(r"'(\w+)'", re.search(r"ICP=\[(.*)\]", text).group(1))

    def start(self, t):
        u, par = np.zeros(self.ndim), np.zeros(len(self.parameters))
        self._library.stpnt(self.ndim, ctypes.c_double(t), pointer(u), pointer(par))
        return u, par

    def rates(self, u, par):
        f = np.full(self.ndim, np.nan)
        self._library.func(self.ndim, pointer(u), None, pointer(par), 0, pointer(f), None, None)
        return f

    def conditions(self, u0, u1, par):
        fb = np.full(self.nbc, np.nan)
        ends = pointer(u0), pointer(u1)
        self._library.bcnd(self.ndim, pointer(par), None, self.nbc, *ends, 0, pointer(fb), None)
        return fb


def pointer(array):
    return np.ascontiguousarray(array).ctypes.data_as(ctypes.c_void_p)


@pytest.fixture(scope="module", params=RODS)
def problem(request, tmp_path_factory):
    folder = tmp_path_factory.mktemp(request.param)
    (folder / "powers.toml").write_text(POWERS)
    with pytest.MonkeyPatch.context() as patch:
        patch.chdir(folder)
        patch.setenv("RODWNL_CACHE", str(folder / "cache"))
        assert cli.run(["export", "--format", "auto", *RODS[request.param], "out.c"]) == 0
    return Problem(folder, (folder / "out.c").read_text())


@gcc
def test_the_mode_solves_the_equations(problem):
    t = (1 - np.cos(np.pi * (np.arange(64) + 0.5) / 64)) / 2
    states = np.array([problem.start(x)[0] for x in t])
    par = problem.start(0.0)[1]
    rates = np.array([problem.rates(u, par) for u in states])
    for state, rate in zip(states.T, rates.T, strict=True):
        slope = np.polynomial.Chebyshev.fit(t, state, 63, domain=[0, 1]).deriv()(t)
        assert np.max(np.abs(slope - rate)) < 1e-8 * np.max(np.abs(rates))


@gcc
def test_the_mode_satisfies_the_conditions(problem):
    (u0, par), (u1, _) = problem.start(0.0), problem.start(1.0)
    largest = max(np.max(np.abs(problem.start(t)[0])) for t in np.linspace(0, 1, 9)) * np.max(par)
    assert np.max(np.abs(problem.conditions(u0, u1, par))) < 1e-10 * largest
    wrong = problem.conditions(u0, u1 + 1e-3, par)
    assert np.sum(np.abs(wrong) > 1e-4) >= 6


@gcc
def test_as_many_unknowns_as_conditions(problem):
    assert len(problem.free) == problem.nbc - problem.ndim + 1
    assert set(problem.free) <= set(problem.parameters)


@gcc
def test_another_solver_finds_the_threshold_again(problem):
    """From a load and a frequency that are five per cent off, by collocation as AUTO does."""
    at = [problem.parameters.index(name) for name in problem.free[1:]]
    t = np.linspace(0, 1, 41)
    guess, par = np.array([problem.start(x)[0] for x in t]).T, problem.start(0.0)[1]

    def with_unknowns(p):
        changed = par.copy()
        changed[at] = p
        return changed

    shift = np.array([1.05 if name != "nu" else 1.001 for name in problem.free[1:]])
    solved = solve_bvp(
        lambda x, y, p: np.array([problem.rates(u, with_unknowns(p)) for u in y.T]).T,
        lambda y0, y1, p: problem.conditions(y0, y1, with_unknowns(p)),
        t,
        guess,
        p=par[at] * shift,
        tol=1e-6,
        max_nodes=2000,
    )
    assert solved.success, solved.message
    assert solved.p == pytest.approx(par[at], rel=1e-6)
