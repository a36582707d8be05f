"""Other tools' conventions: a conversion leaves alone what does not depend on how the mode is scaled."""

import json
from dataclasses import replace
from functools import cache

import mpmath as mp
import numpy as np
import pytest

from rodwnl import RodParameters, cli
from rodwnl.dialects import CONVENTIONS, checked_mesh, convert
from rodwnl.errors import InputError
from rodwnl.exact import exact_threshold
from rodwnl.modes import critical_mode
from rodwnl.quadrature import gauss_legendre

ROD = RodParameters(200, "1e4", "1e-4")
STARTS = [(49.76, 334.32), (155.60, 3367.28)]


@pytest.fixture(autouse=True)
def _thirty_digits():
    with mp.workdps(30):
        yield


@cache
def found_from(start):
    return exact_threshold(ROD, *start, 20)


@pytest.fixture(params=STARTS, ids=["lower", "upper"])
def threshold(request):
    return found_from(request.param)


def cubic_and_linear(converted, omega):
    """(c1 or its real part, β or None) of dw/dt = (iω + βδ)w + c1 w|w|², from each tool's own numbers."""
    n = converted.numbers
    return {
        "paper": lambda: (n["alpha"], n["beta"]),
        "kuznetsov": lambda: (n["c1"], None),
        "matcont": lambda: (n["l1"], None),
        "bifurcationkit": lambda: (n["b"], n["a"]),
        "jaxcont": lambda: (2 * omega * n["l1"], None),
        "ff-bifbox": lambda: (-n["beta"], -n["alpha"]),
    }[converted.convention]()


@pytest.mark.parametrize("name", CONVENTIONS)
@pytest.mark.parametrize("mesh", [1, 7, 1000])
def test_invariants_survive_every_conversion(threshold, name, mesh):
    converted = convert(ROD, threshold, name, mesh if CONVENTIONS[name].norm == "mesh" else None)
    c1, beta = cubic_and_linear(converted, threshold.omega)
    beta = threshold.beta if beta is None else beta
    assert mp.almosteq(beta, threshold.beta, 1e-18)
    # |w|² = −(Re β/Re c1) δ, and the tip moves by 2|w| times the tip value 1/norm of the unit vector
    slope = -4 * beta.real / mp.re(c1) / converted.norm**2
    assert mp.almosteq(slope, threshold.A_tip2_slope, 1e-18)
    if mp.im(c1) != 0:
        assert mp.almosteq(beta.imag - c1.imag * beta.real / c1.real, threshold.omega_slope, 1e-18)


def test_kuznetsovs_l1_is_the_others_up_to_their_factors(threshold):
    l1 = {
        name: convert(ROD, threshold, name, 50).numbers["l1"] for name in ("kuznetsov", "matcont", "jaxcont")
    }
    assert mp.almosteq(l1["matcont"], l1["kuznetsov"] * threshold.omega, 1e-18)
    assert mp.almosteq(l1["jaxcont"], l1["kuznetsov"] / 2, 1e-18)
    assert mp.sign(l1["kuznetsov"]) == mp.sign(threshold.alpha.real)


@pytest.mark.parametrize("mesh", [1, 3, 40])
def test_mesh_norm_is_that_of_the_nodal_values(threshold, mesh):
    # the float64 mode evaluated at the nodes themselves
    u = np.arange(1, mesh + 1) / mesh
    nodes = replace(gauss_legendre(mesh), u=u)
    mode = critical_mode(ROD.floats(), float(threshold.force), float(threshold.omega), nodes)
    expected = np.linalg.norm(np.concatenate([mode.Y, mode.Theta]))
    assert float(convert(ROD, threshold, "matcont", mesh).norm) == pytest.approx(expected, rel=1e-9)


def test_weighted_norm_is_the_integral(threshold):
    nodes = gauss_legendre(40)
    mode = critical_mode(ROD.floats(), float(threshold.force), float(threshold.omega), nodes)
    square = nodes.weights @ (abs(mode.Y) ** 2 + float(ROD.gamma3) * abs(mode.Theta) ** 2)
    assert float(convert(ROD, threshold, "ff-bifbox").norm) == pytest.approx(np.sqrt(square), rel=1e-9)


def test_a_two_norm_depends_on_the_mesh(threshold):
    coarse, fine = (convert(ROD, threshold, "kuznetsov", n).numbers["l1"] for n in (1000, 2000))
    assert abs(coarse / fine - 2) < 0.01


@pytest.mark.parametrize(
    ("name", "mesh", "message"),
    [
        ("auto", None, "there are paper, kuznetsov"),
        ("kuznetsov", None, "depends on the mesh: give its number of intervals"),
        ("paper", "10", "leave out --mesh"),
        ("matcont", "0", "whole number from 1 to 1000000"),
        ("matcont", "1e3", "whole number from 1 to 1000000"),
        ("matcont", "10000000000", "whole number from 1 to 1000000"),
    ],
)
def test_what_a_convention_needs(name, mesh, message):
    with pytest.raises(InputError, match=message):
        checked_mesh(name, mesh)


def test_the_command_prints_them(capsys):
    rod = ["landau", "--k1", "200", "--k2", "1e4", "--gamma3", "1e-4"]
    assert cli.run([*rod, "--convention", "bifurcationkit", "--mesh", "100", "--json"]) == 0
    entry = json.loads(capsys.readouterr().out)["thresholds"][0]
    assert entry["convention"]["numbers"]["a"] == entry["beta"]
    assert entry["convention"]["mesh"] == 100
    assert cli.run([*rod, "--convention", "paper", "--json"]) == 0
    entry = json.loads(capsys.readouterr().out)["thresholds"][0]
    assert cli.run([*rod, "--json"]) == 0
    plain = json.loads(capsys.readouterr().out)["thresholds"][0]
    assert entry["convention"]["numbers"] == {name: entry[name] for name in ("alpha", "beta")}
    assert entry["error"].keys() == plain["error"].keys()
    for name in ("force", "omega", "A_tip2_slope", "omega_slope"):
        assert abs(float(entry[name]) - float(plain[name])) <= float(plain["error"][name])
        assert 0 < float(entry["error"][name]) < 1e-15 * float(entry[name])
    assert cli.run([*rod, "--convention", "kuznetsov", "--mesh", "100"]) == 0
    assert "l1 = Re c1/omega" in capsys.readouterr().out
    assert cli.run([*rod, "--convention", "paper", "--certified"]) == 2
    assert cli.run([*rod, "--mesh", "3"]) == 2
    assert capsys.readouterr().err.count("\n") == 2
