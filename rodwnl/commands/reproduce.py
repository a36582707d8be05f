"""`rodwnl reproduce`: the paper's numeric tables beside computed values."""

from typing import TYPE_CHECKING, Any

from rodwnl.options import Digits, Json, read_digits
from rodwnl.output import complex_number, number, print_json, print_table

if TYPE_CHECKING:
    from rodwnl.tables import Cell, PrintedRow

_MARKS = {"numeric": "", "erratum": " (erratum)", "differs": " (DIFFERS)"}


def command(json: Json = False, digits: Digits = None) -> int:
    """The paper's tables, cell by cell, beside computed values at the printed precision.

    A cell that does not hold is shown with more digits and with the value of an independent computation. The
    exit code is 1 if such a cell is not a reviewed erratum, or if an erratum no longer holds.
    """
    from rodwnl.tables import compared_rows

    wanted = read_digits(digits)
    rows = compared_rows()
    cells = [cell for _, row_cells in rows for cell in row_cells]
    counts = {status: sum(cell.status == status for cell in cells) for status in _MARKS}
    exact = [] if wanted is None else _exact_entries([row for row, _ in rows], wanted)
    if json:
        print_json({"tables": [_entry(cell) for cell in cells], "counts": counts, "exact": exact})
    else:
        for table in dict.fromkeys(row.table for row, _ in rows):
            _print_one(table, [(row, row_cells) for row, row_cells in rows if row.table == table])
        _print_exceptions([cell for cell in cells if cell.status != "numeric"])
        for entry in exact:
            _print_exact(entry)
        print(", ".join(f"{count} {status}" for status, count in counts.items()))
    return 1 if counts["differs"] else 0


def _print_one(table: str, rows: "list[tuple[PrintedRow, tuple[Cell, ...]]]") -> None:
    """A line as printed and one line for each way of computing, in the paper's order."""
    columns = list(rows[0][0].cells)
    lines = []
    for row, cells in rows:
        rod = [f"{name} = {text}" for name, text in row.rod.texts().items() if name != "gamma1"]
        lines.append([row.name, ", ".join(rod), "printed", *row.cells.values()])
        for method in dict.fromkeys(cell.method for cell in cells):
            by_column = {c.column: c.computed + _MARKS[c.status] for c in cells if c.method == method}
            lines.append(["", "", method or "computed", *(by_column.get(c, "") for c in columns)])
    print_table(["row", "rod", "", *columns], lines, title=table)


def _print_exceptions(cells: "list[Cell]") -> None:
    if not cells:
        return
    print_table(
        ["cell", "printed", "computed", "independent", "digits that agree"],
        [
            [
                " ".join(part for part in (cell.table, cell.row, cell.column, cell.method) if part),
                cell.printed,
                _digits(cell.value),
                _digits(cell.independent),
                str(cell.agreement),
            ]
            for cell in cells
        ],
        title="Cells that do not hold to their printed digits",
    )
    for cell in cells:
        if cell.status == "differs":
            print(f"{cell.table} {cell.row} {cell.column}: {cell.remark or 'not a reviewed erratum'}")


def _exact_entries(rows: "list[PrintedRow]", digits: int) -> list[dict[str, Any]]:
    """Each threshold that the tables speak of, once, to so many digits."""
    from rodwnl.exact import exact_threshold
    from rodwnl.precise import NUMBERS_OF_HOPF, exact_entry
    from rodwnl.spectrum import hopf_thresholds

    entries = {}
    for row in rows:
        if (row.rod, row.threshold) not in entries:
            seed = hopf_thresholds(row.rod)[row.threshold - 1]
            found = exact_threshold(row.rod, seed.force, seed.omega, digits)
            numbers = exact_entry(found, (*NUMBERS_OF_HOPF, "alpha", "beta"))
            entries[row.rod, row.threshold] = {"row": row.name, "rod": row.rod.texts(), **numbers}
    return list(entries.values())


def _print_exact(entry: dict[str, Any]) -> None:
    parts = {"force": entry["force"], "omega": entry["omega"]}
    for name in ("alpha", "beta"):
        parts[f"Re {name}"], parts[f"Im {name}"] = entry[name]
    title = f"{entry['row']} to {entry['digits']} digits"
    print_table(["", "computed"], [[name, text] for name, text in parts.items()], title=title)


def _digits(value: complex) -> str:
    return complex_number(value) if isinstance(value, complex) else number(value)


def _entry(cell: "Cell") -> dict[str, Any]:
    texts = ("table", "row", "column", "method", "printed", "computed", "status", "remark")
    values = {"value": _texts(cell.value), "independent": _texts(cell.independent)}
    return {name: getattr(cell, name) for name in texts} | values | {"agreement": cell.agreement}


def _texts(value: complex) -> str | list[str]:
    return [repr(value.real), repr(value.imag)] if isinstance(value, complex) else repr(float(value))
