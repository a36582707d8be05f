import io
import json
import math
import subprocess
import sys

import pytest
from hypothesis import given
from hypothesis import strategies as st

from rodwnl.errors import ComputationError
from rodwnl.output import complex_number, measured, number, print_json, print_table


@pytest.mark.parametrize(
    ("value", "error", "text"),
    [
        (0.101766, 1e-7, "0.101766"),
        (0.03051, 0.0055, "0.031 ± 0.006"),
        (12345.6, 678, "12300 ± 700"),
        (191.4, 0.9, "191.4 ± 0.9"),
        (1e-3, 0.2, "0.0 ± 0.2"),
        (0.5, 0.0, "0.500000000000"),
    ],
)
def test_what_has_few_certain_digits_is_printed_with_its_error(value, error, text):
    assert measured(value, error) == text


@pytest.mark.parametrize(
    ("value", "error", "text"),
    [
        (1 / 3, 1e-5, "0.3333"),
        (12345.678, 2, "1.235e+4"),
        (1e-9, 1e-6, "0.00000"),
        (-1e-9, 1e-6, "0.00000"),
        (1e-9, 1e-12, "1.00e-9"),
        (191.21043, 0, "191.210430000"),
        (9.99996, 1e-4, "10.000"),
        (-328902.123, 1e-3, "-328902.12"),
    ],
)
def test_number_prints_the_certain_digits(value, error, text):
    assert number(value, error) == text


@given(st.floats(-1e9, 1e9), st.floats(1e-12, 1e6), st.floats(-1, 1))
def test_the_last_printed_digit_is_within_one_of_the_truth(value, error, fraction):
    text = number(value, error)
    mantissa, _, exponent = text.partition("e")
    unit = 10.0 ** (int(exponent or 0) - len(mantissa.partition(".")[2]))
    truth = value + fraction * error
    assert abs(float(text) - truth) <= unit * (1 + 1e-9) + abs(value) * 1e-15
    assert len(mantissa.strip("-0.")) <= 14


@pytest.mark.parametrize("value", [math.nan, math.inf])
def test_no_number_is_made_of_a_failure(value):
    with pytest.raises(ComputationError, match=r"1\.0 with the error (nan|inf) is not a number"):
        number(1.0, value)
    with pytest.raises(ComputationError, match=f"{value} with the error 0.0 is not a number"):
        number(value)
    with pytest.raises(ValueError, match="not JSON compliant"):
        print_json({"force": value})


def test_complex_numbers_look_like_the_papers():
    assert complex_number(-971.793 + 29.0912j, 4e-3) == "-971.79 + 29.09i"
    assert complex_number(1 - 2j, digits=3) == "1.00 - 2.00i"


def test_a_piped_table_is_neither_folded_nor_cut(capsys):
    wide = ["x" * 300, "[bold]not markup[/bold]", "ω"]
    print_table(["one", "two", "three"], [wide], title="T")
    lines = capsys.readouterr().out.splitlines()
    assert any(all(cell in line for cell in wide) for line in lines)
    assert all(line == line.rstrip() for line in lines)


def test_a_table_survives_an_output_that_knows_only_ascii(monkeypatch):
    raw = io.BytesIO()
    monkeypatch.setattr("sys.stdout", io.TextIOWrapper(raw, encoding="ascii", errors="backslashreplace"))
    print_table(["ω"], [["1"]])
    sys.stdout.flush()
    assert b"1" in raw.getvalue()


def test_json_is_one_document(capsys):
    print_json({"force": "37.66", "name": "γ"})
    assert json.loads(capsys.readouterr().out) == {"force": "37.66", "name": "γ"}


def test_json_loads_neither_rich_nor_mpmath():
    code = (
        "import sys; from rodwnl import cli\n"
        "cli.run('hopf --model metric-drag --k1 200 --k2 1e4 --gamma3 1e-4 --max-force 60 --json'.split())\n"
        "print(sorted({'rich.console', 'rich.table', 'mpmath'} & set(sys.modules)), file=sys.stderr)"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stderr == "[]\n"
    assert json.loads(done.stdout)["thresholds"]
