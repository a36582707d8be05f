"""landau --order 5, predict --order 5 and the pitchfork of landau, as a user runs them."""

import json

import pytest

from rodwnl import cli

ROD = ["--k1", "160", "--k2", "1e4", "--gamma3", "1e-4"]
DEAD = ["--k1", "500", "--k2", "500", "--gamma3", "1e-3", "--model", "partial_follower"]


@pytest.fixture
def said(capsys):
    def run(*arguments, code=0):
        assert cli.run(arguments) == code
        out, err = capsys.readouterr()
        return err if code else out

    return run


def test_landau_at_order_five(said):
    cubic = json.loads(said("landau", *ROD, "--json"))["thresholds"]
    both = json.loads(said("landau", *ROD, "--order", "5", "--json"))["thresholds"]
    for before, after in zip(cubic, both, strict=True):
        assert before.items() <= after.items()
        assert after["order"] == 5
        assert {"beta2", "alpha_prime", "alpha5", "A_tip2_curvature", "omega_curvature"} <= set(after)
    lower, upper = both
    assert lower["fold"] is None
    assert float(upper["fold"]["force"]) > float(upper["force"])
    table = said("landau", *ROD, "--order", "5")
    assert "A_tip2_curvature" in table
    assert "Threshold 2: by these coefficients the branch turns around near force" in table


def test_order_five_to_any_number_of_digits(said):
    (near,) = json.loads(
        said("landau", "--k1", "1e4", "--k2", "1e4", "--gamma3", "1e-4", "--order", "5", "--json")
    )["thresholds"]
    (exact,) = json.loads(
        said(
            "landau",
            "--k1",
            "1e4",
            "--k2",
            "1e4",
            "--gamma3",
            "1e-4",
            "--order",
            "5",
            "--digits",
            "20",
            "--json",
        )
    )["thresholds"]
    assert exact["A_tip2_curvature"] == "-0.00039781484304829295973"
    for name in ("A_tip2_curvature", "omega_curvature"):
        assert float(near[name]) == pytest.approx(float(exact[name]), rel=1e-9)
    for name in ("beta2", "alpha_prime", "alpha5"):
        assert [float(x) for x in near[name]] == pytest.approx([float(x) for x in exact[name]], rel=1e-9)


def test_predict_at_order_five_is_nearer_to_the_orbit(said):
    rod = ["--k1", "1e4", "--k2", "1e4", "--gamma3", "1e-4", "--force", "40", "--json"]
    orbit = json.loads(said("orbit", *rod))["orbit"]
    cubic, quintic = (
        json.loads(said("predict", *rod, "--order", order))["predictions"][0] for order in ("3", "5")
    )
    for name in ("A_tip", "omega"):
        truth = float(orbit[name])
        assert abs(float(quintic[name]) - truth) < 0.6 * abs(float(cubic[name]) - truth)


def test_buckling_has_a_pitchfork(said):
    arguments = ["landau", *DEAD, "--parameter", "chi=0", "--max-force", "5"]
    (steady,) = json.loads(said(*arguments, "--json"))["steady"]
    assert float(steady["force"]) == pytest.approx(2.4674011002723395)
    assert float(steady["y_tip2_slope"]) == pytest.approx(1.314045728599595)
    assert steady["criticality"] == "supercritical"
    assert "supercritical: beta" in said(*arguments)


def test_a_buckled_rod_is_predicted(said):
    rod = ["--k1", "1e4", "--k2", "1e4", "--gamma3", "1e-4", "--model", "partial-follower"]
    arguments = ["predict", *rod, "--parameter", "chi=0.3", "--force"]
    document = json.loads(said(*arguments, "5", "--json"))
    assert document["predictions"] == []
    (steady,) = document["steady"]
    assert (steady["side"], steady["exists"], steady["stable"]) == ("above", True, True)
    assert float(steady["threshold"]) == pytest.approx(4.0550174)
    squared = 0.7100415756 * (5 - float(steady["threshold"]))  # the slope in docs/order5.md
    assert float(steady["y_tip"]) ** 2 == pytest.approx(squared, rel=1e-9)
    assert "stable   0.8191318" in said(*arguments, "5")
    (steady,) = json.loads(said(*arguments, "3", "--json"))["steady"]
    assert (steady["exists"], steady["y_tip"]) == (False, None)
    assert "none here: it lies above the threshold" in said(*arguments, "3")


def test_order_five_says_that_it_stops_at_three_where_the_rod_buckles(said):
    rod = [*DEAD, "--parameter", "chi=0"]
    for command in (["landau", *rod, "--max-force", "5"], ["predict", *rod, "--force", "3"]):
        assert "at a steady crossing the numbers are those of order 3." in said(*command, "--order", "5")
        assert "order 3" not in said(*command)
    document = json.loads(said("landau", *rod, "--max-force", "5", "--order", "5", "--json"))
    assert "those of order 3" in document["notes"][-1]


def test_other_orders_and_combinations_are_refused(said):
    assert "order 3 or 5" in said("landau", *ROD, "--order", "4", code=2)
    assert "order 3 or 5" in said("predict", *ROD, "--force", "60", "--order", "7", code=2)
    assert "--order 5" in said("landau", *ROD, "--order", "5", "--convention", "paper", code=2)
