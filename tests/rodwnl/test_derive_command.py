import pytest

from rodwnl import cli

DERIVE = ["derive", "--model", "follower"]


@pytest.fixture
def written(tmp_path, capsys):
    folder = tmp_path / "out"
    assert cli.run([*DERIVE, "--out", str(folder)]) == 0
    capsys.readouterr()
    return folder


def check(folder, capsys):
    code = cli.run([*DERIVE, "--check", "--out", str(folder)])
    return code, capsys.readouterr().out


def test_what_is_written_is_what_the_check_expects(written, capsys):
    assert check(written, capsys)[0] == 0
    assert cli.run([*DERIVE, "--out", str(written)]) == 0
    assert " 0 changed" in capsys.readouterr().out


def test_the_committed_modules_are_what_the_derivation_writes(capsys):
    code = cli.run(["derive", "--check"])
    assert (code, capsys.readouterr().out.count("\n")) == (0, 1)


def test_a_changed_a_missing_and_a_surplus_file_are_found(written, capsys):
    changed, missing, surplus = (written / "follower" / f"{n}.py" for n in ("rod", "landau", "surplus"))
    changed.write_text(changed.read_text().replace("xp.cos", "xp.sin", 1))
    missing.unlink()
    surplus.write_text("x = 1\n")
    before = {path: path.read_text() for path in written.rglob("*.py")}
    code, diff = check(written, capsys)
    assert code == 1
    for head in ("--- a/follower/rod.py", "+++ b/follower/landau.py", "--- a/follower/surplus.py"):
        assert head in diff
    assert "\n-    t0 = xp.sin(theta)\n+    t0 = xp.cos(theta)\n" in diff
    assert {path: path.read_text() for path in written.rglob("*.py")} == before


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["--show", "g3", "--check"], "--show prints an object and writes nothing"),
        (["--format", "latex"], "add --show"),
        (["--show", "g1", "--order", "9"], "--order is 9, but it must be 3, 5 or 7"),
        (["--explain", "g1", "--order", "4"], "--order is 4, but it must be 3, 5 or 7"),
        (["--show", "g3", "--format", "word"], "'word' is not one of 'text', 'latex', 'python'"),
        (["--out", __file__], "is a file: --out needs a folder"),
    ],
)
def test_options_that_make_no_sense_together(capsys, arguments, message):
    assert cli.run(["derive", *arguments]) == 2
    out, err = capsys.readouterr()
    assert out == ""
    assert message in err
    assert err.count("\n") == 1


@pytest.mark.parametrize(
    ("form", "start", "part"),
    [
        ("text", "g2 = ", "Theta_u (1 - k2/k1)"),
        ("latex", "\\begin{aligned}\ng_2 =", r"\tilde{k}_2"),
        ("python", "g2 = ", "k2/k1"),
    ],
)
def test_a_derived_object_is_shown(capsys, form, start, part):
    assert cli.run(["derive", "--show", "g2", "--format", form]) == 0
    shown = capsys.readouterr().out
    assert shown.startswith(start)
    assert part in shown


def test_an_unknown_object_lists_the_known_ones(capsys):
    assert cli.run(["derive", "--show", "g9"]) == 2
    error = capsys.readouterr().err
    assert "nothing derived is called 'g9'" in error
    assert {"g1", "g2", "g3", "g4", "alpha", "beta", "h1_3"} <= set(error.replace(",", "").split())
    assert error.count("\n") == 1
