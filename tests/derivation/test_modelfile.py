"""Rods from files: formulas are read by a grammar and never evaluated; errors say where they are."""

import ast
import os
import re
import shlex
import subprocess
import sys
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st
from sympy import Rational, exp, log, sqrt

from derivation.constitutive import expand_model
from derivation.emit.write import render
from derivation.errors import ModelError, ReadError
from derivation.formula import FormulaError, read_formula
from derivation.model import MODELS
from derivation.modelfile import LOADS, read_model
from derivation.modules import package
from derivation.pipeline import derive
from derivation.symbols import symbol
from rodwnl import cli, kernels
from rodwnl.errors import InputError
from rodwnl.models import emitted, find_model

SIDES = ("left", "right")
EXAMPLES = Path(__file__).resolve().parents[2] / "examples"
NAMES = ("h1", "h2", "k1", "theta")
H1, H2, K1 = symbol("h1"), symbol("h2"), symbol("k1")

PLAIN = """name = "mine"
energy = "k1*(h1 - 1)^2/2 + k2*h2^2/2 + Pi^2/2"
[drag]
v1 = "gamma1"
v2 = "1"
Omega = "gamma3"
[[load]]
kind = "follower"
"""


@pytest.fixture(autouse=True)
def own_cache(tmp_path, monkeypatch):
    monkeypatch.setenv("RODWNL_CACHE", str(tmp_path / "cache"))


@pytest.mark.parametrize(
    ("text", "value"),
    [
        ("k1*(h1 - 1)^2/2", K1 * (H1 - 1) ** 2 / 2),
        ("-h1^2", -(H1**2)),
        ("2^-1", Rational(1, 2)),
        ("2^3^2", Rational(512)),
        ("1 - 2 - 3", Rational(-4)),
        ("8/4/2", Rational(1)),
        ("0.1", Rational(1, 10)),
        ("2.5e-3*h1", H1 / 400),
        ("+h1", H1),
        ("sqrt(h1^2 + h2^2)", sqrt(H1**2 + H2**2)),
        ("h1^(1/2)", sqrt(H1)),
        ("exp(h1)*log(h2)", exp(H1) * log(H2)),
        (" h1\n + h2 ", H1 + H2),
    ],
)
def test_formulas_mean_what_they_say(text, value):
    assert read_formula(text, NAMES) == value


@pytest.mark.parametrize(
    ("text", "place", "message"),
    [
        ("h1 +", (1, 5), r"expected '\(', '\+', '-', a name or a number, found the end"),
        ("h1 ** 2", (1, 5), r"found '\*'"),
        ("(h1", (1, 4), r"expected '\)', '\+' or '-', found the end"),
        ("h1)", (1, 3), r"found '\)'"),
        ("h1 h2", (1, 4), r"or the end, found 'h2'"),
        ("h1\n + @", (2, 4), r"found '@'"),
        ("", (1, 1), "found the end"),
        ("foo*h1", (1, 1), "unknown name 'foo'; allowed are h1, h2, k1, theta"),
        ("k1(h1 - 1)", (1, 1), r"'k1' is no function; .*write a product as name\*"),
        ("tan(h1)", (1, 1), "'tan' is no function; there are cos, sin, sqrt, exp, log"),
        ("1 + cos", (1, 5), "needs its argument in parentheses"),
        ("__import__('os').system('true')", (1, 12), "found"),
        ("h1.__class__", (1, 3), "found"),
        (
            "h1^k1",
            (1, 1),
            r"an exponent must be a whole or half number up to 12, not k1; .*exp\(p\*log\(a\)\)",
        ),
        ("9^9^9", (1, 1), "an exponent must be"),
        ("((9^12)^12)^12", (1, 1), "a number with more than"),
        ("((h1^12)^2)^2", (1, 1), "of degree 48, higher than 24"),
        ("1e999999999", (1, 1), "a number with more than 40 digits"),
        ("(" * 31 + "h1" + ")" * 31, (1, 31), "more than 30 parentheses"),
        ("h1 + " * 500 + "h1", (1, 1), "2502 characters, more than 2000"),
        ("h1/(1 - 1)", (1, 1), "divides by zero"),
    ],
)
def test_what_is_no_formula_is_refused_with_its_place(text, place, message):
    with pytest.raises(FormulaError, match=message) as error:
        read_formula(text, NAMES)
    assert (error.value.line, error.value.column) == place


@given(st.text(alphabet="h12k()+-*/^. \n_[]{}'\"eE0cosθ", max_size=40))
def test_any_text_is_read_or_refused(text):
    found = None
    try:
        read_formula(text, NAMES)
    except FormulaError as error:
        found = error
    assert found is None or (str(found) and 1 <= found.line <= text.count("\n") + 1)


@pytest.mark.parametrize("name", ["follower", "metric_drag", "quartic", "distributed"])
def test_an_example_is_the_shipped_rod_to_the_byte(name):
    text = (EXAMPLES / f"{name}.toml").read_text()
    assert render(package(derive(read_model(text)))) == render(package(derive(MODELS[name])))


def test_the_partial_follower_of_the_examples_has_the_shipped_theory():
    """Its loads are given by kind, so that only the exact tip load is spelt in another order."""
    texts = render(package(derive(read_model((EXAMPLES / "partial_follower.toml").read_text()))))
    shipped = render(package(derive(MODELS["partial_follower"])))
    differing = {path for path, text in shipped.items() if texts[path] != text}
    assert differing <= {"partial_follower/rod.py", "partial_follower/__init__.py"}


def test_every_example_runs(capsys):
    files = sorted(EXAMPLES.glob("*.toml"))
    assert {file.stem for file in files} >= set(MODELS)
    for file in files:
        rod = ["--k1", "1e4", "--k2", "1e2", "--gamma3", "1e-2", "--model", str(file), "--max-force", "90"]
        assert cli.run(["landau", *rod]) == 0
        out = capsys.readouterr().out
        assert f"Rod {file.stem!r} with k1 = 10000" in out
        assert "supercritical" in out


def changed(*edits):
    text = PLAIN
    for old, new in edits:
        assert old in text
        text = text.replace(old, new)
    return text


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("name = ", "not TOML: "),
        (changed(('name = "mine"\n', "")), "^name is missing"),
        ("", "^name is missing"),
        (changed(('"mine"', '"my rod"')), "name is 'my rod', but it must be a name"),
        (changed(('"mine"', '"../../x"')), "must be a name of letters"),
        (changed(('"mine"', '"__init__"')), "no __, and not begin"),
        (changed(('"mine"', '"class"')), "name is 'class', a word that Python reserves; take another"),
        (PLAIN + '[parameters]\nlambda = { default = "1" }\n', "parameter is 'lambda', a word that Python"),
        (changed(("energy =", "enrgy =")), "the file has an unknown 'enrgy'; it may hold name, title"),
        (changed(('v2 = "1"\n', "")), r"\[drag\] needs v2"),
        (changed(('"follower"', '"gravity"')), "load 1: kind is 'gravity'; it must be one of follower, dead"),
        (changed(('kind = "follower"', 'kind = "spring"')), r"load 1 \(spring\) needs stiffness"),
        (changed(('kind = "follower"', 'kind = "follower"\nfoo = 1')), r"load 1 \(follower\) has an unknown"),
        (changed(("[[load]]", "[load]")), "load must be a list"),
        (changed(('[[load]]\nkind = "follower"\n', "")), "either .*load.* entries or one .tip. table"),
        (PLAIN + '[parameters]\nk1 = { default = "1" }\n', "'k1': the name has a meaning already"),
        (PLAIN + '[parameters]\nnu = { default = "1" }\n', "'nu': the name has a meaning already"),
        (PLAIN + '[parameters]\nshear = { default = "1" }\n', "'shear': the name has a meaning already"),
        (PLAIN + '[parameters]\ng1 = { default = "1" }\n', "'g1': the name has a meaning already"),
        *(
            (PLAIN + f'[parameters]\n{name} = {{ default = "1" }}\n', f"{name!r}: the name has a meaning")
            for name in ("y0", "theta1_u", "x_u", "Y_u", "Theta300", "c210", "k1_inv", "a_bar", "C2_010")
        ),
        (PLAIN + "[parameters]\na = 3\n", "parameter 'a' must be a table"),
        (PLAIN + "[parameters]\na = {}\n", "'a' needs a default"),
        (PLAIN + '[parameters]\na = { default = "sqrt(2)" }\n', "must be a rational number"),
        (PLAIN + '[parameters]\na = { default = "1", meaning = "\\"\\"\\"" }\n', "must not hold quotes"),
        (changed(('"mine"', '"mine"\ntitle = "a\\nb"')), "title must be one line"),
        (changed(('v1 = "gamma1"', "v1 = true")), "v1 of .drag. must be a formula in quotes"),
        (changed(('v1 = "gamma1"', 'v1 = ""')), "v1 of .drag.: expected"),
    ],
)
def test_what_is_no_model_is_refused(text, message):
    with pytest.raises(ModelError, match=message):
        read_model(text)


@pytest.mark.parametrize(
    ("edit", "message"),
    [
        (("Pi^2/2", "Pi^2/2 + foo"), r"line 2: column 50: energy: unknown name 'foo'"),
        (('"gamma1"', '"gamma1*v1"'), r"line 4: column 14: v1 of .drag.: unknown name 'v1'"),
        (('"gamma3"', '"gamma3 +"'), r"line 6: column 18: Omega of .drag.: expected .*found the end"),
    ],
)
def test_an_error_in_a_formula_is_found_in_the_file(edit, message):
    with pytest.raises(ReadError, match=message):
        read_model(changed(edit))


@pytest.mark.parametrize("transverse", ["0", "2/7"])
@pytest.mark.parametrize("axial", ["0", "1/3"])
@pytest.mark.parametrize(
    ("main", "turning"),
    [
        *(("follower", ""), ("follower", "spring"), ("follower", "damper")),
        *(("dead", ""), ("distributed", ""), ("distributed", "damper")),
    ],
)
def test_every_combination_of_loads_is_derived_and_emitted(main, turning, axial, transverse):
    """The derivation proves its own steps; variables without load at the tip exist where there is none."""
    text = changed(('"follower"', f'"{main}"'))
    text += f'[[load]]\nkind = "drag"\naxial = "{axial}"\ntransverse = "{transverse}"\n'
    if turning:
        text += f'[[load]]\nkind = "{turning}"\n{LOADS[turning][0]} = "3/2"\n'
    derived = derive(read_model(text))
    free = main != "dead" and not turning and axial == transverse == "0"
    assert (derived.third.transformed is not None) == free
    assert bool(derived.landau.norm.boundary) == (transverse != "0" or turning == "damper")
    modules = render(package(derived))
    assert ("mine/third_order.py" in modules) == free
    for node in (node for text in modules.values() for node in ast.walk(ast.parse(text))):
        literals = [isinstance(node, ast.BinOp) and isinstance(getattr(node, s), ast.Constant) for s in SIDES]
        assert not (all(literals) and isinstance(node.op, ast.Div)), ast.unparse(node)
        assert not (isinstance(node, ast.Constant) and isinstance(node.value, float))


@pytest.mark.parametrize(
    ("edit", "message"),
    [
        (("Pi^2/2", "Pi^2/2 + h2^2*Pi"), r"not symmetric under reflection .*h1\^0 h2\^2 Pi\^1"),
        (("Pi^2/2", "Pi^2/2 + h2*Pi"), "couples shear and bending at the straight rod"),
        (("+ Pi^2/2", ""), "is zero: the energy is not convex"),
        (("Pi^2/2", "Pi^2/2 + sqrt(h2^2)^3"), "is not smooth at the straight rod"),
        (('v2 = "1"', 'v2 = "1 + h2"'), "drag component 2 is not symmetric under reflection"),
        (('v2 = "1"', 'v2 = "h2^2"'), "drag component 2 vanishes at the straight rod"),
        (('kind = "follower"', 'kind = "follower"\nshare = "1/2"'), r"is \(-force/2, 0, 0\), but it must be"),
        (
            ('kind = "follower"', 'kind = "follower"\n[[load]]\nkind = "distributed"'),
            "beside a distributed load",
        ),
    ],
)
def test_a_broken_assumption_is_named(edit, message):
    with pytest.raises(ModelError, match=message):
        expand_model(read_model(changed(*zip(edit[::2], edit[1::2], strict=True))), 3)


def test_a_formula_that_is_not_real_is_refused():
    for law in ("sqrt(-1)*Pi^4", "log(-2)*Pi^4"):
        with pytest.raises(ReadError, match="it is not real: a root or a logarithm of a negative number"):
            read_model(changed(("Pi^2/2", f"Pi^2/2 + {law}")))


def test_terms_that_cancel_break_no_assumption():
    energy = "Pi^2/2 + ((k1 + 1)^2 - k1^2 - 2*k1 - 1)*h2*(Pi + 1)"
    assert expand_model(read_model(changed(("Pi^2/2", energy))), 3).stiffness[2] == 1


def test_an_energy_that_is_not_convex_in_numbers_is_refused(tmp_path, capsys):
    file = tmp_path / "rod.toml"
    file.write_text(changed(("Pi^2/2", "Pi^2/2 - Pi^2")))
    rod = ["--k1", "1e4", "--k2", "1e4", "--gamma3", "1e-4", "--model", str(file)]
    assert cli.run(["hopf", *rod]) == 2
    assert "the bending stiffness is -1, but its energy must be convex" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("edit", "message"),
    [
        (
            ("Pi^2/2", "Pi^2/2 + log(h1 - 1)"),
            "stiffness of the undeformed rod is -inf, but its energy must be",
        ),
        (('v1 = "gamma1"', 'v1 = "gamma1*sqrt(h1 - 2)"'), "the axial drag is nan, but drag must be positive"),
        (('v2 = "1"', 'v2 = "-1"'), "the transverse drag is -1, but drag must be positive"),
        (("k1*(h1", "-k1*(h1"), "stretch stiffness of the undeformed rod is -10000, but its energy must be"),
    ],
)
def test_an_energy_or_drag_that_fails_in_numbers_is_refused_by_the_name_of_the_rod(
    tmp_path, capsys, edit, message
):
    file = tmp_path / "rod.toml"
    file.write_text(changed(edit))
    rod = ["--k1", "1e4", "--k2", "1e4", "--gamma3", "1e-4", "--model", str(file)]
    assert cli.run(["hopf", *rod]) == 2
    error = capsys.readouterr().err
    assert error.startswith("rodwnl: rod 'mine'")
    assert message in error
    assert error.count("\n") == 1
    assert cli.run(["hopf", *rod, "--parameter", "kapa=1"]) == 2
    assert capsys.readouterr().err.startswith("rodwnl: rod 'mine' has no parameter 'kapa'; it has none")


def test_a_law_that_is_complex_for_these_parameters_is_refused(tmp_path, capsys):
    file = tmp_path / "rod.toml"
    file.write_text(
        changed(("Pi^2/2", "Pi^2/2 + sqrt(chi)*Pi^4")) + '\n[parameters]\nchi = { default = "-1" }\n'
    )
    rod = ["--k1", "200", "--k2", "1e4", "--gamma3", "1e-4", "--model", str(file)]
    assert cli.run(["hopf", *rod]) == 2
    assert re.search(r"the stresses at .* are .*, but they must be real\n$", capsys.readouterr().err)
    assert cli.run(["hopf", *rod, "--parameter", "chi=1"]) == 0


@pytest.mark.parametrize(
    "command", [["derive", "--show", "g1"], ["export", "--format", "c", "-"], ["verify"]]
)
def test_a_broken_assumption_is_one_line_in_every_command(tmp_path, capsys, command):
    file = tmp_path / "rod.toml"
    file.write_text(changed(("Pi^2/2", "Pi^2/2 + h2*Pi")))
    assert cli.run([*command, "--model", str(file)]) == 2
    out, error = capsys.readouterr()
    assert (out, error.count("\n")) == ("", 1)
    assert error.startswith(f"rodwnl: {file}: mine: the energy couples shear and bending")


def test_a_tip_load_that_is_no_polynomial_in_a_velocity_is_refused():
    tip = '[tip]\nF1 = "-force"\nF2 = "1 - exp(v2)"\nM = "0"\n'
    model = read_model(changed(('[[load]]\nkind = "follower"\n', tip)))
    with pytest.raises(ModelError, match="tip load F2 must be a polynomial in v1, v2, Omega and force"):
        expand_model(model, 3)


def test_a_cache_that_cannot_be_written_is_found_before_deriving(tmp_path, monkeypatch, capsys):
    file, cache = tmp_path / "rod.toml", tmp_path / "a_file"
    file.write_text(PLAIN)
    cache.write_text("")
    monkeypatch.setenv("RODWNL_CACHE", str(cache))
    monkeypatch.setattr("derivation.pipeline.derive", None)
    assert cli.run(["hopf", "--k1", "1", "--k2", "1", "--gamma3", "1", "--model", str(file)]) == 2
    error = capsys.readouterr().err
    assert error.startswith(f"rodwnl: {cache} cannot be written (File exists): it is the cache folder")
    assert "RODWNL_CACHE moves it" in error


def test_a_mark_at_the_beginning_of_a_file_is_no_part_of_it(tmp_path):
    file = tmp_path / "rod.toml"
    file.write_text(PLAIN, encoding="utf-8-sig")
    assert find_model(str(file)) == read_model(PLAIN)


@pytest.mark.skipif(not hasattr(os, "mkfifo"), reason="no pipes with names here")
def test_what_is_no_regular_file_is_refused(tmp_path):
    pipe = tmp_path / "rod.toml"
    os.mkfifo(pipe)
    for place in (pipe, tmp_path):
        with pytest.raises(InputError, match="is no regular file"):
            emitted(str(place))


def test_a_file_is_derived_once_and_again_when_it_changes(tmp_path, monkeypatch):
    file = tmp_path / "rod.toml"
    file.write_text(PLAIN)
    first = emitted(str(file))
    stamp = (Path(first) / "__init__.py").stat().st_mtime_ns
    assert emitted(str(file)) == first
    assert (Path(first) / "__init__.py").stat().st_mtime_ns == stamp
    file.write_text(PLAIN + '[parameters]\na = { default = "1" }\n')
    second = emitted(str(file))
    assert second != first
    assert kernels.own_parameters(second) == {"a": "1"}
    # What was spoilt in the cache is derived again.
    spoilt = Path(second) / "landau.py"
    spoilt.write_text("def alpha_boundary(): return 0\n")
    with pytest.raises(InputError, match="fingerprint differs"):
        kernels.load.__wrapped__(second)
    kernels.load.cache_clear()
    assert emitted(str(file)) == second
    assert "alpha_untransformed" in spoilt.read_text()


def test_derive_writes_the_rod_of_a_file(tmp_path, capsys):
    file, out = tmp_path / "rod.toml", tmp_path / "out"
    file.write_text(PLAIN)
    assert cli.run(["derive", "--model", str(file), "--out", str(out)]) == 0
    assert (out / "mine" / "landau.py").is_file()
    assert cli.run(["derive", "--model", str(file), "--check", "--out", str(out)]) == 0
    assert cli.run(["derive", "--model", str(file)]) == 2
    assert "say where to write with --out DIR" in capsys.readouterr().err
    assert cli.run(["derive", "--model", str(file), "--show", "g2"]) == 0
    assert "Theta_u" in capsys.readouterr().out


def test_a_huge_file_and_one_that_is_no_text_are_refused(tmp_path):
    file = tmp_path / "rod.toml"
    file.write_text("#" * 100_001)
    with pytest.raises(InputError, match="is longer than 100000 bytes"):
        emitted(str(file))
    file.write_bytes(b"\xff\xfe")
    with pytest.raises(InputError, match="is not a text in UTF-8"):
        emitted(str(file))


def test_the_page_for_new_users_is_true(tmp_path, monkeypatch, capsys):
    """Its files, its commands and its Python run as they stand, with the numbers that it shows."""
    page = (EXAMPLES.parent / "docs" / "your-rod.md").read_text()
    blocks = re.findall(r"^```(\w*)\n(.*?)^```", page, re.MULTILINE | re.DOTALL)
    monkeypatch.chdir(tmp_path)
    files = [text for kind, text in blocks if kind in ("toml", "latex")]
    for name, text in zip(("rod.toml", "mine.tex", "letters.toml"), files, strict=True):
        Path(name).write_text(text)
    ran = 0
    for text in (text for kind, text in blocks if not kind and text.startswith("$ ")):
        for call in re.findall(r"^\$ rodwnl (.*)$", text, re.MULTILINE):
            assert cli.run(shlex.split(call)) == 0, call
            ran += 1
        printed = capsys.readouterr().out
        for number in re.findall(r"\d+\.\d{6,}", text):
            assert number[:-4] in printed, number
    assert ran == 7
    (program,) = [text for kind, text in blocks if kind == "python"]
    subprocess.run([sys.executable, "-c", program], check=True, capture_output=True)
    assert Path("my-rod/mine/landau.py").is_file()
