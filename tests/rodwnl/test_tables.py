import math
from dataclasses import replace

import pytest
from hypothesis import given
from hypothesis import strategies as st

from rodwnl import tables
from rodwnl.errors import ComputationError
from rodwnl.parameters import RodParameters
from rodwnl.spectrum import hopf_thresholds
from rodwnl.tables import (
    Erratum,
    PrintedRow,
    at_printed_precision,
    centred_slope,
    compare,
    compared_rows,
    errata,
    printed_rows,
)

ROW = PrintedRow("tab:t", "(a)", RodParameters(1, 1, 1), 1, {"force": "2.50", "alpha": "-1.20 - 3.4i"})
VALUES = {"force": 2.4951, "alpha": -1.2049 - 3.4499j}
ERRATUM = Erratum("tab:t", "(a)", "alpha", "-1.20 - 3.4i", "-1.21 - 3.4i", "a proof")


def cells(values=VALUES, known=()):
    return {c.column: c for c in compare(ROW, {name: (v, v) for name, v in values.items()}, known)}


def statuses(values=VALUES, known=()):
    return {column: cell.status for column, cell in cells(values, known).items()}


@pytest.mark.parametrize(
    ("value", "printed", "text"),
    [
        (37.65598, "37.66", "37.66"),
        (-971.7584 + 29.0708j, "-971.79 + 29.09i", "-971.76 + 29.07i"),
        (328900.63 - 307479.08j, "328902 - 307479i", "328901 - 307479i"),
        (1 - 1e-9j, "1.0 + 0.0i", "1.0 + 0.0i"),
        (155.6001, "155.60", "155.60"),
    ],
)
def test_rounding_to_the_printed_decimals(value, printed, text):
    assert at_printed_precision(value, printed) == text


@given(st.floats(-1e6, 1e6), st.integers(0, 6))
def test_a_cell_holds_exactly_within_half_a_unit(value, decimals):
    printed = f"{value:.{decimals}f}"
    unit = 10.0**-decimals
    assert float(at_printed_precision(value, printed)) == float(printed)
    assert at_printed_precision(value + 1.01 * unit, printed) != printed


def test_a_cell_that_is_no_number_is_refused():
    with pytest.raises(ComputationError, match=r"'7\.35 \+ 5\.36' is not a number"):
        at_printed_precision(1, "7.35 + 5.36")


def test_cells_that_round_to_what_is_printed_hold():
    assert statuses() == {"force": "numeric", "alpha": "numeric"}


def test_a_cell_that_does_not_round_to_what_is_printed_differs():
    assert statuses(values=VALUES | {"alpha": -1.2051 - 3.4j})["alpha"] == "differs"
    assert statuses(values=VALUES | {"alpha": -1.2 - 3.34j})["alpha"] == "differs"
    assert statuses(values=VALUES | {"force": 2.505001})["force"] == "differs"


def test_a_listed_erratum_is_confirmed_with_its_evidence():
    values = VALUES | {"alpha": -1.2051 - 3.4j}
    assert statuses(values=values, known=(ERRATUM,))["alpha"] == "erratum"
    assert cells(values, (ERRATUM,))["alpha"].remark == "a proof"


@pytest.mark.parametrize(
    ("values", "erratum"),
    [
        (VALUES, ERRATUM),  # the printed cell holds after all
        (VALUES | {"alpha": -1.22 - 3.4j}, ERRATUM),  # neither printed nor listed
        (VALUES | {"alpha": -1.2051 - 3.4j}, replace(ERRATUM, printed="-1.19 - 3.4i")),  # of another printing
    ],
)
def test_an_erratum_that_does_not_hold_is_a_difference(values, erratum):
    cell = cells(values, (erratum,))["alpha"]
    assert cell.status == "differs"
    assert "does not hold" in cell.remark


def test_an_erratum_speaks_of_its_own_cell_only():
    for other in ({"label": "tab:u"}, {"row": "(b)"}, {"column": "beta"}):
        assert statuses(known=(replace(ERRATUM, **other),))["alpha"] == "numeric"


def test_digits_of_agreement():
    def agreement(value, independent):
        return compare(ROW, {"force": (value, independent)}, ())[0].agreement

    assert agreement(2.5, 2.5) == 15
    assert agreement(2.5, 2.5 * (1 + 2e-9)) == 8
    assert agreement(2.5, -2.5) == -1


def test_the_tables_are_whole():
    rows = printed_rows()
    assert [row.table for row in rows] == ["tab:parameters"] * 4 + ["tab:beta_check"] * 4
    assert all(len(row.cells) == 4 for row in rows)
    # both tables print β and F_c of the same four thresholds
    for first, second in zip(rows[:4], rows[4:], strict=True):
        assert (first.rod, first.threshold) == (second.rod, second.threshold)
        assert first.cells["force"] == second.cells["force"]
        assert first.cells["beta"] == second.cells["beta"]
        growth, sign, frequency = second.cells["beta"].rstrip("i").split(" ")
        assert second.cells["growth_slope"] == growth
        assert second.cells["frequency_slope"] == frequency
        assert sign == "+"


def test_every_erratum_names_a_cell_as_it_is_printed():
    printed = {(row.table, row.name, c): text for row in printed_rows() for c, text in row.cells.items()}
    for erratum in errata():
        assert printed[erratum.label, erratum.row, erratum.column] == erratum.printed
        assert erratum.computed != erratum.printed
        assert erratum.evidence


def test_the_computed_tables():
    rows = compared_rows()
    assert [row for row, _ in rows] == list(printed_rows())
    for row, compared in rows:
        assert [c.column for c in compared if not c.method] == list(row.cells)
        differences = [c.column for c in compared if c.method]
        assert differences == [c for c in row.cells if c.endswith("_slope")]
        for cell in compared:
            assert cell.status in {"numeric", "erratum"}
            # the centred difference has the error δF²/6 |λ'''|, everything else only round-off
            assert cell.agreement >= (5 if cell.method else 9)


def test_the_centred_difference_is_of_second_order():
    rod = RodParameters(200, "1e4", "1e-4")
    for threshold in hopf_thresholds(rod):
        coarse, fine = (abs(centred_slope(rod, threshold, step) - threshold.slope) for step in (0.4, 0.2))
        assert math.log2(coarse / fine) == pytest.approx(2, abs=0.1)


def test_a_row_of_a_threshold_that_is_not_there(monkeypatch):
    row = replace(printed_rows()[0], threshold=3)
    monkeypatch.setattr(tables, "printed_rows", lambda: (row,))
    with pytest.raises(ComputationError, match=r"tab:parameters \(a, b\): found 1 thresholds, not number 3"):
        compared_rows.__wrapped__()
