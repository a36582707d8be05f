import subprocess
import sys

import pytest

import rodwnl


@pytest.mark.parametrize("name", rodwnl.__all__)
def test_every_public_name_is_there(name):
    assert getattr(rodwnl, name) is not None


def test_an_unknown_name_lists_the_known_ones():
    with pytest.raises(AttributeError, match=r"'landaus'.*RodParameters"):
        _ = rodwnl.landaus


ROD = rodwnl.RodParameters(200, "1e4", "1e-4")
NO_ROD = r"^rod must be a RodParameters \(as RodParameters\(200, '1e4', '1e-4'\) makes one\), not "


@pytest.mark.parametrize("stranger", ["rod", None, 200, (200, 1e4, 1e-4)], ids=repr)
@pytest.mark.parametrize(
    ("name", "more"),
    [
        ("hopf_thresholds", ()),
        ("landau", ()),
        ("predict", (50,)),
        ("predict_buckled", (50,)),
        ("amplitude_equation", (None,)),
        ("pitchfork", (None,)),
        ("simulate", (50,)),
        ("periodic_orbits", (50,)),
        ("bistability", ()),
        ("reduced_model", (50,)),
    ],
)
def test_what_is_no_rod_is_refused_in_one_sentence(name, more, stranger):
    with pytest.raises(rodwnl.InputError, match=NO_ROD):
        getattr(rodwnl, name)(stranger, *more)


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (lambda: rodwnl.RodParameters(200, 1, 1, model=None), r"model must be a str \(the name .*, not None"),
        (lambda: rodwnl.RodParameters(200, 1, 1, scales=3), r"scales must be a Scales \(as .*, not 3"),
        (lambda: rodwnl.simulate(ROD, 50, rtol=None), r"rtol must be a number, not None"),
        (lambda: rodwnl.simulate(ROD, 50, rtol="1"), r"rtol is 1, but it must lie between"),
        (lambda: rodwnl.predict(ROD, 50, "3"), r"order is '3', but .* to 3 or 5"),
        (lambda: rodwnl.amplitude_equation(ROD, 50), r"threshold must be a HopfThreshold .*, not 50"),
        (lambda: rodwnl.pitchfork(ROD, None), r"threshold must be a HopfThreshold .*, not None"),
        (lambda: rodwnl.reduced_model(ROD, 50, 1), r"coefficients must be a LandauCoefficients .*, not 1"),
    ],
)
def test_values_of_another_kind_are_refused_by_name(call, message):
    with pytest.raises(rodwnl.InputError, match=message):
        call()


def test_a_tolerance_may_be_a_text():
    assert rodwnl.simulate(ROD, 45, "0.01", rtol="1e-6").rtol == 1e-6


def test_importing_the_package_imports_no_library():
    libraries = ["numpy", "scipy", "sympy", "typer", "rich"]
    code = f"import sys, rodwnl; print([m for m in {libraries} if m in sys.modules])"
    result = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert result.stdout.strip() == "[]"
