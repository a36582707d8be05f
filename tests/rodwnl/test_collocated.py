"""Spectral integration of any rod: against the exponentials of the plain one, and against closed forms."""

from fractions import Fraction
from math import acos, pi

import numpy as np
import pytest
from scipy.optimize import brentq

from rodwnl import cli, expansion, landau_batch, report, straightrod, thresholds
from rodwnl.batch_rods import Rods, largest_forces
from rodwnl.coefficients import landau, landau_at
from rodwnl.collocated import STEP, leading_eigenvalues, nearest, pencil, static_sign, stepped, unstable_count
from rodwnl.errors import ComputationError, InputError
from rodwnl.models import emitted
from rodwnl.parameters import RodParameters
from rodwnl.predictions import predict
from rodwnl.quadrature import gauss_legendre
from rodwnl.report import sentences
from rodwnl.spectrum import hopf_thresholds
from rodwnl.straightrod import largest_force, parameter_values, straight_rod

RODS = [(1e4, 1e4, 1e-4), (1e4, 1e2, 1e-2), (200, 1e4, 1e-4)]  # of tab:parameters
SAME = 1e-11  # two routes in float64; what is found is below 1e-12


@pytest.mark.parametrize("values", RODS)
def test_the_plain_rod_has_the_same_thresholds_and_coefficients_by_exponentials(values):
    rod = RodParameters(*values)
    by_integration = thresholds.Collocation(rod)
    for c in landau(rod):
        low, high = 0.99 * c.force, 1.01 * c.force
        found = by_integration.threshold(low, high, 1.001 * c.force, 1.002 * c.omega)
        assert found.force == pytest.approx(c.force, rel=SAME)
        assert found.omega == pytest.approx(c.omega, rel=SAME)
        assert abs(found.slope / c.threshold.slope - 1) < SAME
        assert abs(found.force - c.force) <= found.force_error + c.threshold.force_error
        nodes = thresholds.nodes_at(rod, c.force, c.omega)
        parts, _, residuals = expansion.evaluate(rod, c.force, c.omega, nodes)
        alpha, beta = parts.sum(axis=1)
        assert abs(alpha / c.alpha - 1) < SAME
        assert abs(beta / c.beta - 1) < SAME
        assert max(residuals.values()) < 1e-10


@pytest.mark.parametrize("model", ["metric_drag", "quartic", "partial_follower", "distributed"])
def test_slopes_of_the_eigenvalues_are_derivatives(model):
    rod = RodParameters(200, 1e4, 1e-4, model=model)
    eigenvalue, slope = leading_eigenvalues(rod, np.array([29.0, 30.0, 31.0]), 6)
    for here, exact in zip(eigenvalue[1], slope[1], strict=True):
        near = [row[np.argmin(abs(row - here))] for row in (eigenvalue[0], eigenvalue[2])]
        assert (near[1] - near[0]) / 2 == pytest.approx(exact, rel=2e-3)


@pytest.mark.parametrize("model", ["metric_drag", "quartic", "partial_follower", "distributed"])
def test_more_nodes_change_nothing(model):
    rod = RodParameters(200, 1e4, 1e-4, model=model)
    (start, *_), _ = (row[0] for row in leading_eigenvalues(rod, np.array([60.0]), 2))
    found = []
    for count in (32, 48, 96):
        p = pencil(straight_rod(rod, 60.0), gauss_legendre(count))
        found.append(nearest(p, 1.01 * start).eigenvalue)
    assert abs(found[1] / found[0] - 1) < 1e-11
    assert abs(found[2] / found[0] - 1) < 1e-11


def test_the_left_vector_is_the_adjoint_of_the_exponentials():
    rod = RodParameters(200, 1e4, 1e-4)
    c = landau(rod)[0]
    from rodwnl.modes import adjoint_mode

    nodes = thresholds.nodes_at(rod, c.force, c.omega)
    exact = adjoint_mode(rod.floats(), c.force, c.omega, nodes)
    mode = expansion.critical_mode(straight_rod(rod, c.force), c.omega, nodes)
    turn = exact.Psi_Y_tip / mode.Psi_Y_tip
    np.testing.assert_allclose(turn * mode.Psi_Y, exact.Psi_Y, rtol=0, atol=1e-10)
    np.testing.assert_allclose(turn * mode.Psi_Theta, exact.Psi_Theta, rtol=0, atol=1e-10)


def test_slopes_of_the_pencil_are_exact():
    rod = RodParameters(200, 1e4, 1e-4, model="quartic")
    nodes = gauss_legendre(24)
    _, A_force, _ = stepped(rod, 50.0, nodes)
    step = 1e-4
    above, below = (pencil(straight_rod(rod, 50.0 + s), nodes).A for s in (step, -step))
    np.testing.assert_allclose((above - below) / (2 * step), A_force, atol=1e-7)
    assert STEP < 1e-50


@pytest.mark.parametrize("chi", ["0", "0.2", "0.45"])
@pytest.mark.parametrize("values", [(1e4, 1e4, 1e-4), (200, 100, 1e-2)])
def test_buckling_has_a_closed_form(chi, values):
    """Steady, k2 H = F(Θ − χΘ(1)) and Θ'' + μH = 0: cos p = −χ/(1 − χ) with p² = F(ν + F/k2)."""
    k1, k2, _ = values
    search = hopf_thresholds(RodParameters(*values, model="partial_follower", chi=chi), 60)
    first = search.steady[0]
    p = acos(-float(chi) / (1 - float(chi)))
    a, b = 1 / k2 - 1 / k1, p * p  # a F² + F = b
    exact = 2 * b / (1 + (1 + 4 * a * b) ** 0.5)
    assert first.force == pytest.approx(exact, rel=1e-12)
    assert abs(first.force - exact) <= first.force_error + 1e-14 * exact
    assert first.steady
    assert (first.omega, first.unstable_below, first.unstable_above) == (0, 0, 1)
    assert first.crossing == "destabilizing"


def buckling_of_a_sprung_rod(rod, upper):
    """Steady, k2 H = F(Θ − Θ(1)) and Θ'' + μH = 0, Θ'(1) = −κΘ(1): sin p = −p/κ with p² = F(ν + F/k2)."""
    k1, k2, kappa = float(rod.k1), float(rod.k2), float(dict(rod.own)["kappa"])

    def defect(force):
        return np.sinc(np.sqrt(force * (1 - force / k1 + force / k2)) / pi) + 1 / kappa

    forces = np.geomspace(1e-5, upper, 4001)
    values = np.array([defect(f) for f in forces])
    changes = np.flatnonzero(values[1:] * values[:-1] < 0)
    return [brentq(defect, forces[i], forces[i + 1], xtol=1e-13) for i in changes]


@pytest.mark.parametrize(
    ("values", "kappa"),
    [((200, 1e4, 1e-4), k) for k in ("5", "50", "1e6", "-5", "-50")]
    + [((1e4, 1e4, 1e-4), k) for k in ("1e4", "1e9", "-1.0001")]
    + [((3158, "37.16", "1.052e-8", "0.1027"), "54.13")],  # a pair becomes real beside a crossing
)
def test_every_buckling_of_a_sprung_rod_is_found(sprung, values, kappa):
    """Of springs soft and stiff, and of those that push: then the rod is unstable without any force."""
    rod = sprung(values, kappa)
    search = hopf_thresholds(rod, all_crossings=True)
    found = sorted(t.force for t in (*search.steady, *search.later) if t.omega == 0)
    exact = buckling_of_a_sprung_rod(rod, float(search.max_force))
    assert found == pytest.approx(exact, rel=1e-11)
    assert search.unstable_unloaded == (1 if float(kappa) < -1 else 0)
    assert search.steady == hopf_thresholds(rod).steady


@pytest.mark.parametrize("kappa", ["-500", "-5e4", "-5e6"])
def test_a_boundary_layer_at_the_tip_is_counted_however_thin(sprung, kappa):
    rod = sprung((200, 1e4, 1e-4), kappa)
    assert [unstable_count(rod, force) for force in (0.0, 30.0, 150.0)] == [1, 2, 3]


def test_a_rod_unstable_without_a_force_says_so(sprung):
    rod = sprung((200, 1e4, 1e-4), "-1.5")
    search = hopf_thresholds(rod)
    assert (search.unstable_unloaded, search.steady[0].crossing) == (1, "restabilizing")
    assert report.document(search, [])["unstable_unloaded"] == 1
    unstable = hopf_thresholds(sprung((200, 1e4, 1e-4), "-50"))
    said = report.sentences(unstable)
    assert "The straight rod is unstable already at force = 0: 1 eigenvalue has positive real part." in said
    assert said[-1] == "No Hopf threshold: it is unstable in the whole range."


def test_a_rod_that_is_neither_stable_nor_unstable_without_a_force_is_refused(sprung):
    message = "at F = 0 the straight rod is neither stable nor unstable: .* change a parameter a little"
    with pytest.raises(ComputationError, match=message):
        hopf_thresholds(sprung((200, 1e4, 1e-4), "-1"))


def test_a_window_of_buckling_before_flutter_is_seen():
    """Between two forces that a coarse scan takes, a real eigenvalue crosses and comes back; then a pair."""
    rod = RodParameters("1246.63", "22.8", "4.556e-5", "0.837", model="partial_follower", chi="0.4305")
    search = hopf_thresholds(rod)
    assert [t.crossing for t in search.steady] == ["destabilizing", "restabilizing"]
    for t in search.steady:
        sides = [static_sign(rod, t.force * (1 + side)) for side in (-1e-9, 1e-9)]
        assert sides[0] == -sides[1]
    (flutter,) = search
    assert search.steady[1].force < flutter.force
    assert [unstable_count(rod, force) for force in (4, 7, 10.35, 10.4)] == [0, 1, 0, 2]


def test_flutter_after_recovery_from_buckling_is_seen():
    """A real unstable eigenvalue at one end of an interval and a complex pair at the other are not one."""
    own = {"model": "partial_follower", "chi": "0.3912"}
    search = hopf_thresholds(RodParameters("220.4", "92.51", "0.005183", "0.07794", **own))
    assert [round(t.force, 5) for t in search] == [14.88839]
    assert [round(t.force, 5) for t in search.steady] == [4.99056, 14.75155]


@pytest.mark.parametrize(
    ("values", "chi", "thresholds"),
    [
        ((3143, 72250, 8.164e-6, 0.3036), 1.1544, [43.0469]),
        ((12840, 32040, 4.153e-6, 0.4112), 0.4469, [18.8704]),
        ((427, 225300, 3.51e-6, 1.029), 0.5233, [21.7024]),
    ],
)
def test_a_rod_with_little_rotational_drag_is_not_refused(values, chi, thresholds):
    """Near F = 0 dλ/dF is a small difference of K's largest entries."""
    rod = RodParameters(*values, model="partial_follower", chi=chi)
    assert [t.force for t in hopf_thresholds(rod)] == pytest.approx(thresholds, abs=1e-4)
    batch = landau_batch(*values, model="partial_follower", chi=chi)
    assert batch.force[0] == pytest.approx(thresholds[0], abs=1e-4)


def test_a_steady_crossing_is_said_and_has_no_coefficients_of_an_oscillation(capsys):
    rod = RodParameters(1e4, 1e4, 1e-4, model="partial_follower", chi=0)
    search = hopf_thresholds(rod)
    assert len(search) == 0
    with pytest.raises(InputError, match=r"at force = 2\.4674011 the rod buckles .*no frequency"):
        landau_at(rod, search.steady[0])
    line = ["hopf", "--k1", "1e4", "--k2", "1e4", "--gamma3", "1e-4", "--model", "partial-follower"]
    assert cli.run([*line, "--parameter", "chi=0"]) == 0
    out = capsys.readouterr().out
    assert f"At force = {pi**2 / 4:.9f}" in out
    assert "a steady crossing, omega = 0" in out
    assert "No Hopf threshold." in out


@pytest.mark.parametrize("model", ["metric_drag", "partial_follower"])
@pytest.mark.parametrize(("k1", "bound"), [(200, "199.8"), ("137", "136.863"), ("33.3", "33.2667")])
def test_the_range_ends_where_the_rod_is_compressed_to_a_thousandth(model, k1, bound):
    """nu = 1 - F/k1 is linear: the bound is a short decimal, and is printed as one."""
    assert largest_force(RodParameters(k1, 1e4, 1e-4, model=model), Fraction(400)) == (Fraction(bound), True)


def test_the_search_ends_where_the_straight_rod_ends():
    soft = RodParameters(200, 1e4, 1e-4, model="quartic", stretch4=-100)
    # F = k1 (1 − ν) − 100 (1 − ν)³ is largest where k1 = 300 (1 − ν)²
    strain = (2 / 3) ** 0.5
    force, cut = largest_force(soft, soft.k1)
    assert cut
    assert float(force) == pytest.approx(200 * strain - 100 * strain**3, rel=1e-8)
    assert largest_force(RodParameters(200, 1e4, 1e-4, model="distributed"), soft.k1)[1]


WAVY = """
name = "wavy"
energy = "k1*((h1 - 1)^2/2 + depth*(1 - cos(20*(h1 - 1)))/400) + k2*h2^2/2 + Pi^2/2"
[parameters]
depth = { default = "2" }
[drag]
v1 = "gamma1"
v2 = "1"
Omega = "gamma3"
[[load]]
kind = "distributed"
"""


def test_the_search_ends_where_the_stretch_would_jump_along_the_rod(tmp_path):
    """K1 = k1 (1 + 2 cos 20(1 − ν)) has passed through 0 where it is positive again at the clamp."""
    file = tmp_path / "rod.toml"
    file.write_text(WAVY)
    rod = RodParameters(200, 1e2, 1e-2, model=emitted(str(file)))
    angle = 2 * np.pi / 3
    ends = 200 / 20 * (angle + 2 * np.sin(angle))
    force, cut = largest_force(rod, Fraction(100))
    assert cut
    assert float(force) == pytest.approx(ends, rel=1e-8)
    with pytest.raises(
        InputError, match=r"the stretch stiffness is -.*, but its energy must be convex there"
    ):
        predict(rod, 80)


@pytest.mark.parametrize("kind", ["follower", "distributed"])
@pytest.mark.parametrize(("energy", "bound"), [("(h1 - 1)^2/2", "0.999"), ("k1*(h1 - 1)^2", "399.6")])
def test_a_stretch_stiffness_that_is_no_parameter(tmp_path, energy, bound, kind):
    """1, and 2 k1: ν is found, and the range ends where F = K1 (1 − ν) compresses the rod to a thousandth."""
    file = tmp_path / "rod.toml"
    lines = WAVY.replace('"distributed"', f'"{kind}"').splitlines()
    lines[2] = f'energy = "{energy} + k2*h2^2/2 + Pi^2/2"'
    file.write_text("\n".join(lines))
    rod = RodParameters(200, 1e2, 1e-2, model=emitted(str(file)))
    force, cut = largest_force(rod, Fraction(1000))
    assert cut
    assert float(force) == pytest.approx(float(bound), rel=1e-9)


def test_a_stretch_that_is_not_found_is_one_line(tmp_path, monkeypatch):
    """Where Newton's method does not arrive, here because it may take one step only."""
    file = tmp_path / "rod.toml"
    file.write_text(WAVY)
    straight = straight_rod(RodParameters(200, 1e2, 1e-2, model=emitted(str(file)), depth="0.5"), 40)
    monkeypatch.setattr(straightrod, "MOST_STEPS", 1)
    with pytest.raises(
        InputError, match=r"force = 40 no stretch of the straight rod was found at u = 0\.25; "
    ):
        straight.stretch(np.array([0.125, 0.25]))


BREAKING = """
name = "breaking"
energy = "k1*(h1 - 1)^2/2 + k2*h2^2/2 + Pi^2/2 + bend*(h1 - 1)*Pi^2 + soft*(h1 - 1)*h2^2"
[parameters]
bend = { default = "0" }
soft = { default = "0" }
lost = { default = "0" }
zeta = { default = "0" }
[drag]
v1 = "gamma1"
v2 = "1 + lost*(h1 - 1)"
Omega = "gamma3"
[[load]]
kind = "follower"
[[load]]
kind = "damper"
drag = "zeta"
"""


@pytest.fixture(scope="module")
def breaking(tmp_path_factory):
    folder = tmp_path_factory.mktemp("breaking")
    (folder / "rod.toml").write_text(BREAKING)
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("RODWNL_CACHE", str(folder / "cache"))
        return emitted(str(folder / "rod.toml"))


@pytest.mark.parametrize(
    ("own", "bound", "why"),
    [  # 1 + 20 (h1 - 1) = 0 at F = 10, and a hundredth at 9.9; k2 + 2e5 (h1 - 1) likewise; drag = 0 at F = 20
        ({"bend": 10}, "9.9", "the bending stiffness falls below 0.01 of its value without force"),
        ({"soft": "1e5"}, "9.9", "the shear stiffness falls below 0.01 of its value without force"),
        ({"lost": 10}, "20", "the transverse drag is not positive"),
    ],
)
def test_the_range_ends_where_an_assumption_breaks_and_says_which(own, bound, why, breaking):
    rod = RodParameters(200, 1e4, 1e-4, model=breaking, **own)
    search = hopf_thresholds(rod)
    assert search.range_cut
    assert float(search.max_force) == pytest.approx(float(bound), rel=1e-8)
    assert f"The range ends there: beyond, {why}." in sentences(search)
    batched = largest_forces(
        Rods(breaking, {n: np.array([v]) for n, v in parameter_values(rod).items()}), 400
    )
    assert batched == pytest.approx([float(bound)], rel=1e-8)


def test_a_threshold_below_the_broken_assumption_is_found(breaking):
    (found,) = hopf_thresholds(RodParameters(200, 1e4, 1e-4, model=breaking, bend=10))
    (below,) = hopf_thresholds(RodParameters(200, 1e4, 1e-4, model=breaking, bend=10), 9)
    assert found.force == pytest.approx(below.force, rel=1e-9)
    assert found.force == pytest.approx(7.967488471, rel=1e-9)


def test_a_load_at_the_tip_must_brake(breaking):
    hopf_thresholds(RodParameters(200, 1e4, 1e-4, model=breaking, zeta="1e-3"), 10)
    message = r"straight under force = 0: the rotational drag of the tip load is -0\.001, but it must brake"
    with pytest.raises(InputError, match=message):
        hopf_thresholds(RodParameters(200, 1e4, 1e-4, model=breaking, zeta="-1e-3"))


@pytest.mark.parametrize(
    ("own", "force", "message"),
    [
        ({"stretch4": -100}, 110, r"'quartic' has no straight state at force = 110"),
        ({"stretch4": "1e6"}, -1, r"force is -1, but it must not be negative"),
    ],
)
def test_a_force_without_a_straight_rod_is_refused(own, force, message):
    with pytest.raises(InputError, match=message):
        predict(RodParameters(200, 1e4, 1e-4, model="quartic", **own), force)


def test_an_energy_that_is_not_convex_is_refused_with_the_place():
    with pytest.raises(InputError, match=r"force = 250: the stretch is -0\.25, but the straight rod must"):
        predict(RodParameters(200, 1e4, 1e-4, model="distributed"), 250)


def test_too_many_nodes_are_refused():
    with pytest.raises(ComputationError, match=r"wave number .* nodes would be needed, more than 160"):
        unstable_count(RodParameters("1e8", 5, 1, model="distributed"), 2000)


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["--model", "nope"], "there is no rod 'nope'; there are distributed, follower"),
        (["--model", "quartic", "--parameter", "foo=1"], "no parameter 'foo'; its own are stretch4, bend4"),
        (["--model", "quartic", "--parameter", "bend4"], "write it as NAME=VALUE"),
        (["--model", "quartic", "--parameter", "bend4=x"], "bend4 is 'x': not a finite number"),
        (["--model", "quartic", "--parameter", "k1=3"], "write it as NAME=VALUE, with a name of the model's"),
        (["--model", "quartic", "--parameter", "bend4=1", "--parameter", "bend4=2"], "given twice"),
        (["--parameter", "chi=1"], "name that one with --model"),
        (["--model", "metric-drag", "--parameter", "chi=1"], "it has none beside k1, k2, gamma3 and gamma1"),
        (
            ["--model", "distributed", "--digits", "20"],
            "'distributed' varies along it under its distributed load",
        ),
        (["--model", "distributed", "--certified"], "--certified needs modes that are exponentials"),
        (["--model", "missing.toml"], "missing.toml: No such file"),
    ],
)
def test_what_cannot_be_done_with_a_model_is_one_line(capsys, arguments, message):
    assert cli.run(["hopf", "--k1", "1e4", "--k2", "1e4", "--gamma3", "1e-4", *arguments]) == 2
    out, err = capsys.readouterr()
    assert out == ""
    assert message in err
    assert err.count("\n") == 1


def test_a_rod_in_si_units_keeps_its_own_parameters_dimensionless():
    rod = RodParameters.from_physical(
        L="1e-5", k1="1e-9", k2="1e-9", k3="1e-23", gamma1="1e-3", gamma2="2e-3", gamma3="1e-17",
        model="quartic", bend4="0.2",
    )  # fmt: skip
    assert dict(rod.own) == {"stretch4": 100, "bend4": rod.own[1][1]}
    assert float(rod.own[1][1]) == 0.2
    assert rod.model == "quartic"
    assert "model='quartic'" in repr(rod)
