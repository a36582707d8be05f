"""α and β of rods beyond the paper's: the derivation against the discretised full rod.

The independent route knows nothing of the expansion; its laws are written by hand (`rodwnl.laws`, and below
for rods from files).
"""

from dataclasses import replace
from fractions import Fraction
from pathlib import Path

import numpy as np
import pytest

from rodwnl.coefficients import landau
from rodwnl.lawcycles import law_cycle
from rodwnl.laws import LAWS
from rodwnl.models import emitted
from rodwnl.nilpotent import Nilpotent, cos, nilpotent, sin
from rodwnl.normalform import DiscreteRod, normal_form
from rodwnl.parameters import RodParameters
from rodwnl.responses import pitchfork
from rodwnl.spectrum import hopf_thresholds
from rodwnl.strainform import follower, tip

EXAMPLES = Path(__file__).resolve().parents[2] / "examples"
STIFF, SHEARABLE, SOFT = (1e4, 1e4, 1e-4), (1e4, 1e2, 1e-2), (200.0, 1e4, 1e-4)
CRISP = (200.0, 1e2, 1e-2)
AGREE = 1e-10  # what is found is below 3e-12; a wrong term anywhere is of order one


@pytest.fixture(autouse=True)
def own_cache(tmp_path, monkeypatch):
    monkeypatch.setenv("RODWNL_CACHE", str(tmp_path / "cache"))


def confirm(rod, law):
    """Every threshold of the rod, once more by the independent route; how they cross."""
    parameters = [float(value) for value in (rod.k1, rod.k2, rod.gamma3, rod.gamma1)]
    found = landau(rod)
    for c in found:
        form = normal_form(
            law(*parameters, **{name: float(v) for name, v in rod.own}), round(c.force, 3), round(c.omega, 2)
        )
        assert form.tail < 1e-10
        assert form.force == pytest.approx(c.force, rel=AGREE)
        assert form.omega == pytest.approx(c.omega, rel=AGREE)
        assert abs(form.alpha / c.alpha - 1) < AGREE
        assert abs(form.beta / c.beta - 1) < AGREE
        assert abs(c.beta / c.threshold.slope - 1) < AGREE  # β is dλ/dF
        assert max(c.residuals.values()) < 1e-10
    return [c.crossing for c in found]


@pytest.mark.parametrize(
    ("model", "values", "own", "crossings"),
    [
        ("metric_drag", STIFF, {}, ["destabilizing"]),
        ("metric_drag", SHEARABLE, {}, ["destabilizing"]),
        ("metric_drag", SOFT, {}, ["destabilizing", "restabilizing"]),
        ("quartic", STIFF, {"stretch4": "1e4"}, ["destabilizing"]),
        ("quartic", SOFT, {}, ["destabilizing", "restabilizing"]),
        ("quartic", SOFT, {"stretch4": -100, "bend4": 0}, ["destabilizing", "restabilizing"]),
        ("partial_follower", STIFF, {}, ["destabilizing"]),
        ("partial_follower", SHEARABLE, {"chi": "0.6"}, ["destabilizing"]),
        ("partial_follower", SOFT, {}, ["destabilizing", "restabilizing"]),
        ("distributed", STIFF, {}, ["destabilizing"]),
        ("distributed", (200.0, 100.0, 1e-2), {}, ["destabilizing"]),
    ],
)
def test_shipped_rods_are_confirmed(model, values, own, crossings):
    assert confirm(RodParameters(*values, model=model, **own), LAWS[model]) == crossings


def tip_drag(k1, k2, gamma3, gamma1, *, axial, transverse, spring, damper):
    return replace(
        follower(k1, k2, gamma3, gamma1),
        load=lambda theta, v, force: (
            -force - axial * v[0],
            -transverse * v[1],
            -spring * theta - damper * v[2],
        ),
    )


@pytest.mark.parametrize("values", [STIFF, SOFT])
def test_a_load_with_drag_is_confirmed(values):
    """∂t in the tip conditions: the pairing and dA/dT have terms at the tip."""
    confirm(RodParameters(*values, model=emitted(str(EXAMPLES / "tip_drag.toml"))), tip_drag)


LOADED = """
name = "loaded"
energy = "k1*(h1 - 1)^2/2 + k2*h2^2/2 + Pi^2/2"
[parameters]
axial = {{ default = "1" }}
transverse = {{ default = "2" }}
[drag]
v1 = "gamma1"
v2 = "1"
Omega = "gamma3"
[[load]]
kind = "{kind}"
[[load]]
kind = "drag"
axial = "{axial}"
transverse = "{transverse}"
"""


@pytest.mark.parametrize(
    ("kind", "axial", "transverse"),
    [
        ("follower", "axial", "transverse"),
        ("follower", "3/2", "0"),
        ("distributed", "0", "transverse"),
        ("distributed", "1/7", "2"),
    ],
)
def test_drag_at_the_tip_beside_a_load_that_follows_is_confirmed(tmp_path, kind, axial, transverse):
    """No moment at the tip, so but for the drag the load would have the paper's transformed variables."""
    file = tmp_path / "rod.toml"
    file.write_text(LOADED.format(kind=kind, axial=axial, transverse=transverse))
    rod = RodParameters(*SOFT, model=emitted(str(file)))
    a, b = (float(dict(rod.own).get(text) or Fraction(text)) for text in (axial, transverse))

    def law(*parameters, **own):
        plain = LAWS[kind](*parameters)

        def load(theta, v, force):
            f1, f2, m = plain.load(theta, v, force)
            return f1 - a * v[0], f2 - b * v[1], m

        return replace(plain, load=load)

    assert confirm(rod, law)


EVERYTHING = """
name = "everything"
energy = '''k1*(h1 - 1)^2/2 + k2*h2^2/2 + Pi^2/2
    + a*(h1 - 1)*Pi^2 + b*(h1 - 1)*h2^2 + c2*h2^2*Pi^2 + d*h2^3*Pi'''
[parameters]
a = { default = "0.3" }
b = { default = "40" }
c2 = { default = "25" }
d = { default = "70" }
p = { default = "1/5" }
q = { default = "0.4" }
[drag]
v1 = "gamma1*(1 + p*Pi^2 + q*h2*Pi)*h1"
v2 = "(1 + q*Pi^2)/sqrt(h1)"
Omega = "gamma3*(1 + p*h2^2)*h1^3"
[tip]
F1 = "-force*cos(theta/2) - 0.05*v1*(1 + theta^2)"
F2 = "force*sin(theta)/3 - 0.02*v2"
M = "-0.3*theta - 0.1*theta^3 - 0.002*Omega"
"""


def everything(k1, k2, gamma3, gamma1, *, a, b, c2, d, p, q):
    return replace(
        follower(k1, k2, gamma3, gamma1),
        stress=lambda h1, h2, pi: (
            k1 * (h1 - 1.0) + a * pi * pi + b * h2 * h2,
            k2 * h2 + 2 * b * (h1 - 1.0) * h2 + 2 * c2 * h2 * pi * pi + 3 * d * h2 * h2 * pi,
            pi + 2 * a * (h1 - 1.0) * pi + 2 * c2 * h2 * h2 * pi + d * h2**3,
        ),
        drag=lambda h1, h2, pi: (
            gamma1 * (1.0 + p * pi * pi + q * h2 * pi) * h1,
            (1.0 + q * pi * pi) * h1**-0.5,
            gamma3 * (1.0 + p * h2 * h2) * h1**3,
        ),
        load=lambda theta, v, force: (
            -force * cos(0.5 * theta) - 0.05 * v[0] * (1.0 + theta * theta),
            force * sin(theta) / 3.0 - 0.02 * v[1],
            -0.3 * theta - 0.1 * theta**3 - 0.002 * v[2],
        ),
    )


EXPONENTIAL = """
name = "exponential"
energy = "k1*(exp(h1 - 1) - h1) + k2*h2^2/2*exp(1 - h1) + Pi^2/2"
[drag]
v1 = "gamma1"
v2 = "exp((h1 - 1)/2)"
Omega = "gamma3"
[[load]]
kind = "follower"
"""


def exp(value):
    return value.apply(lambda a, k: np.exp(a)) if isinstance(value, Nilpotent) else np.exp(value)


def exponential(k1, k2, gamma3, gamma1):
    return replace(
        follower(k1, k2, gamma3, gamma1),
        stress=lambda h1, h2, pi: (
            k1 * (exp(h1 - 1.0) - 1.0) - k2 * h2 * h2 / 2 * exp(1.0 - h1),
            k2 * h2 * exp(1.0 - h1),
            pi,
        ),
        drag=lambda h1, h2, pi: (gamma1, exp((h1 - 1.0) / 2), gamma3),
    )


POWERS = """
name = "powers"
energy = "k1*(exp(p*log(h1)) - p*log(h1) - 1)/p^2 + k2*h2^2/2 + Pi^2/2"
[parameters]
p = { default = "27/10" }
[drag]
v1 = "gamma1*exp(p*log(h1))"
v2 = "exp(0.3*log(h1))"
Omega = "gamma3"
[[load]]
kind = "follower"
"""


def powers(k1, k2, gamma3, gamma1, *, p):
    return replace(
        follower(k1, k2, gamma3, gamma1),
        stress=lambda h1, h2, pi: (k1 / p * (h1 ** (p - 1) - h1**-1), k2 * h2, pi),
        drag=lambda h1, h2, pi: (gamma1 * h1**p, h1**0.3, gamma3),
    )


LOGARITHMIC = """
name = "logarithmic"
energy = "k1*(h1 - 1 - log(h1)) + k2*h2^2/2 + Pi^2/2"
[drag]
v1 = "gamma1*h1"
v2 = "1"
Omega = "gamma3"
[[load]]
kind = "follower"
"""


def logarithmic(k1, k2, gamma3, gamma1):
    return replace(
        follower(k1, k2, gamma3, gamma1),
        stress=lambda h1, h2, pi: (k1 * (1.0 - 1.0 / h1), k2 * h2, pi),
        drag=lambda h1, h2, pi: (gamma1 * h1, 1.0, gamma3),
    )


GRADED = """
name = "graded"
energy = "k1*(h1 - 1)^2/2 + k2*h2^2/2 + Pi^2/2 + (h1 - 1)*Pi^2/4 + 30*(h1 - 1)*h2^2"
[drag]
v1 = "gamma1*sqrt(h1^2 + h2^2)"
v2 = "sqrt(h1^2 + h2^2)"
Omega = "gamma3"
[[load]]
kind = "distributed"
"""


def graded(k1, k2, gamma3, gamma1):
    """Under a load along the rod its stretch varies, and with it the stiffnesses and the drag."""

    def drag(h1, h2, pi):
        metric = (h1 * h1 + h2 * h2) ** 0.5
        return gamma1 * metric, metric, gamma3

    return replace(
        LAWS["distributed"](k1, k2, gamma3, gamma1),
        stress=lambda h1, h2, pi: (
            k1 * (h1 - 1.0) + pi * pi / 4 + 30.0 * h2 * h2,
            k2 * h2 + 60.0 * (h1 - 1.0) * h2,
            pi + (h1 - 1.0) * pi / 2,
        ),
        drag=drag,
    )


def loaded(law):
    """A law with the force of `distributed` in place of that at its tip."""

    def along(*parameters, **own):
        plain = LAWS["distributed"](*parameters)
        return replace(law(*parameters, **own), load=plain.load, body=plain.body)

    return along


LOADED_EXPONENTIAL = EXPONENTIAL.replace('"gamma1"', '"gamma1*sqrt(h1^2 + h2^2)"').replace(
    "follower", "distributed"
)


def metric_exponential(*parameters):
    metric, plain = (law(*parameters) for law in (LAWS["metric_drag"], exponential))
    return replace(plain, drag=lambda *h: (metric.drag(*h)[0], *plain.drag(*h)[1:]))


CONSTANTS = """
name = "constants"
energy = "k1*(h1 - 1)^2/2 + k2*h2^2/2 + Pi^2/3 + sqrt(2)/3*Pi^4"
[parameters]
s = { default = "3" }
[drag]
v1 = "gamma1"
v2 = "4/3"
Omega = "gamma3"
[[load]]
kind = "follower"
[[load]]
kind = "spring"
stiffness = "1/s + exp(1)/7"
[[load]]
kind = "damper"
drag = "cos(1)/1000"
"""


def constants(k1, k2, gamma3, gamma1, *, s):
    """Fractions and irrational numbers that stand bare, and a quotient by a parameter in a load."""
    return replace(
        follower(k1, k2, gamma3, gamma1),
        stress=lambda h1, h2, pi: (k1 * (h1 - 1.0), k2 * h2, 2 * pi / 3 + 4 * 2**0.5 / 3 * pi**3),
        drag=lambda h1, h2, pi: (gamma1, 4 / 3, gamma3),
        load=lambda theta, v, force: (
            -force,
            0.0,
            -(1 / s + np.e / 7) * theta - np.cos(1.0) / 1000 * v[2],
        ),
    )


@pytest.mark.parametrize(
    ("text", "law", "values", "crossings"),
    [
        (EVERYTHING, everything, (1e4, 1e3, 1e-3), ["destabilizing"]),
        (EXPONENTIAL, exponential, SOFT, ["destabilizing", "restabilizing"]),
        (POWERS, powers, SOFT, ["destabilizing"]),
        (LOGARITHMIC, logarithmic, SOFT, ["destabilizing"]),
        (GRADED, graded, (1e4, 1e2, 1e-2), ["destabilizing"]),
        ((EXAMPLES / "loaded.toml").read_text(), loaded(LAWS["quartic"]), CRISP, ["destabilizing"]),
        (LOADED_EXPONENTIAL, loaded(metric_exponential), CRISP, ["destabilizing"]),
        (CONSTANTS, constants, (1e4, 1e3, 1e-3), ["destabilizing"]),
    ],
    ids=[
        "everything",
        "exponential",
        "powers",
        "logarithmic",
        "graded",
        "loaded",
        "loaded_exponential",
        "constants",
    ],
)
def test_rods_from_files_are_confirmed(tmp_path, text, law, values, crossings):
    """Couplings of all strains, drag in every strain, loads in angle and velocities; analytic energies."""
    file = tmp_path / "rod.toml"
    file.write_text(text)
    assert confirm(RodParameters(*values, model=emitted(str(file))), law) == crossings


def test_the_comparison_sees_a_wrong_coefficient():
    """A law whose cubic bending differs by a part in a million."""
    rod = RodParameters(*STIFF, model="quartic")
    c = landau(rod)[0]
    own = {name: float(v) for name, v in rod.own}
    off = normal_form(
        LAWS["quartic"](*STIFF, **(own | {"bend4": own["bend4"] * (1 + 1e-6)})), c.force, c.omega
    )
    assert 1e-8 < abs(off.alpha / c.alpha - 1) < 1e-5


def test_quartic_terms_that_vanish_give_the_plain_rod():
    plain = landau(RodParameters(*SOFT))
    none = landau(RodParameters(*SOFT, model="quartic", stretch4=0, bend4=0))
    for a, b in zip(plain, none, strict=True):
        assert b.alpha == pytest.approx(a.alpha, rel=1e-11)
        assert b.A_tip2_slope == pytest.approx(a.A_tip2_slope, rel=1e-11)


@pytest.mark.parametrize(("edit", "k1"), [(("", ""), 200), (("k1*(h1 - 1)^2/2", "k1*(h1 - 1)^2"), 100)])
def test_an_implicit_stretch_under_a_distributed_load_has_the_explicit_limit(tmp_path, edit, k1):
    """Without quartic terms, also where the energy is written with twice the stiffness."""
    file = tmp_path / "rod.toml"
    file.write_text((EXAMPLES / "loaded.toml").read_text().replace(*edit))
    limit = landau(RodParameters(k1, *CRISP[1:], model=emitted(str(file)), stretch4=0, bend4=0))[0]
    plain = landau(RodParameters(*CRISP, model="distributed"))[0]
    for name in ("force", "omega", "alpha", "beta", "A_tip2_slope", "omega_slope"):
        assert getattr(limit, name) == pytest.approx(getattr(plain, name), rel=1e-11)


def test_metric_drag_only_rescales_time_in_the_linear_problem():
    """At the straight rod all drag is ν times larger or smaller: the same force, ω and β in another time."""
    for plain, metric in zip(
        hopf_thresholds(RodParameters(*SOFT)),
        hopf_thresholds(RodParameters(*SOFT, model="metric_drag")),
        strict=True,
    ):
        nu = 1 - plain.force / SOFT[0]
        assert metric.force == pytest.approx(plain.force, rel=1e-12)
        assert metric.omega * nu == pytest.approx(plain.omega, rel=1e-12)


@pytest.mark.parametrize(
    ("model", "limit", "tolerance"), [("follower", 37.695430840318579, 1e-6), ("distributed", 76.1, 0.01)]
)
def test_the_stiff_limit(model, limit, tolerance):
    """With both stiffnesses growing and rotational drag vanishing F_c converges linearly in 1/k.

    The tip load's limit is the root of a transcendental equation; the distributed load's is known to lie
    near 76.
    """
    forces = []
    for exponent in (4, 5, 6):
        rod = RodParameters(10**exponent, 10**exponent, f"1e-{exponent}", model=model)
        forces.append(hopf_thresholds(rod, 100)[0].force)
    first, second = np.diff(forces)
    assert first / second == pytest.approx(10, rel=0.02)
    assert forces[-1] + second / 9 == pytest.approx(limit, abs=tolerance)


def test_a_rod_loaded_along_it_and_across_its_tip_buckles_as_predicted(tmp_path):
    """An exponential energy; the tip's load (0 where it is straight) makes the pitchfork."""
    file = tmp_path / "rod.toml"
    file.write_text(
        LOADED_EXPONENTIAL + '[[load]]\nkind = "dead"\n[[load]]\nkind = "follower"\nshare = "-1"\n'
    )
    rod = RodParameters(*CRISP, model=emitted(str(file)))
    threshold = hopf_thresholds(rod, 10).steady[0]
    predicted = pitchfork(rod, threshold)
    law = replace(
        loaded(metric_exponential)(*CRISP, 0.5),
        load=lambda theta, v, force: (force - force * cos(theta), force * sin(theta), 0.0),
    )
    slopes = [(buckled_force(law, threshold.force, 24, a) - threshold.force) / a**2 for a in (0.02, 0.04)]
    assert (4 * slopes[0] - slopes[1]) / 3 == pytest.approx(1 / predicted.y_tip2_slope, rel=1e-5)
    assert predicted.beta == pytest.approx(threshold.slope.real, rel=1e-9)


def buckled_force(law, force, degree, size):
    """The force under which the rod rests buckled with this tip displacement, by Newton's method."""
    rod = DiscreteRod(law, degree)
    w = rod.straight(force)
    still = np.zeros_like(w)
    mode = np.linalg.svd(rod.jacobian(w, force))[2][-1]
    w = w + mode * size / (rod.tip_row(w, force) @ mode)
    for _ in range(30):
        y, y_w = tip(*rod.split(nilpotent(w)), degree)[1].part(), rod.tip_row(w, force)
        R, R_F = rod.derivative(w, force), rod.derivative(w, force, (still, 1.0))
        matrix = np.block([[rod.jacobian(w, force), R_F[:, None]], [y_w, np.zeros((1, 1))]])
        step = np.linalg.solve(matrix, np.append(R, y - size))
        w, force = w - step[:-1], force - step[-1]
        if np.abs(step).max() < 1e-13 * max(1, force):
            return force
    raise AssertionError("no equilibrium found")


@pytest.mark.parametrize(
    ("model", "values", "own"),
    [
        ("partial_follower", STIFF, {"chi": 0}),
        ("partial_follower", (200.0, 100.0, 1e-2), {"chi": 0}),
        ("partial_follower", SOFT, {"chi": "0.3"}),
    ],
)
def test_a_buckled_rod_is_where_the_pitchfork_says(model, values, own):
    """y_tip² = slope·(F − F_c) + …, on equilibria computed without any expansion."""
    rod = RodParameters(*values, model=model, **own)
    threshold = hopf_thresholds(rod, 30).steady[0]
    predicted = pitchfork(rod, threshold)
    law = LAWS[model](*values, **{name: float(v) for name, v in rod.own})
    slopes = [(buckled_force(law, threshold.force, 24, a) - threshold.force) / a**2 for a in (0.02, 0.04)]
    limit = (4 * slopes[0] - slopes[1]) / 3  # without the term in a²
    assert limit == pytest.approx(1 / predicted.y_tip2_slope, rel=1e-4)
    assert predicted.beta == pytest.approx(threshold.slope.real, rel=1e-9)


@pytest.mark.parametrize(
    ("model", "values", "own", "index"),
    [
        ("metric_drag", STIFF, {}, 0),
        ("metric_drag", SOFT, {}, 1),
        ("quartic", SOFT, {}, 0),
        ("partial_follower", SOFT, {}, 1),
        ("distributed", STIFF, {}, 0),
    ],
)
def test_orbits_of_the_full_rod_leave_the_threshold_as_predicted(model, values, own, index):
    """A_tip² and ω along the branch, on orbits computed without any expansion."""
    c = landau(RodParameters(*values, model=model, **own))[index]
    rod = RodParameters(*values, model=model, **own)
    law = LAWS[model](*values, **{name: float(v) for name, v in rod.own})
    form = normal_form(law, c.force, c.omega, 24)
    sizes = [0.01 * abs(c.A_tip2_slope * c.force) ** 0.5 * s for s in (1, 2)]
    cycles = [law_cycle(law, form, a) for a in sizes]
    # Both are even in the amplitude: two orbits give their slopes but for the fourth power of it.
    first, second = ((x.force - form.force) / x.amplitude**2 for x in cycles)
    assert (4 * first - second) / 3 == pytest.approx(1 / c.A_tip2_slope, rel=1e-4)
    first, second = ((x.omega - form.omega) / (x.force - form.force) for x in cycles)
    assert (4 * first - second) / 3 == pytest.approx(c.omega_slope, rel=1e-4)
