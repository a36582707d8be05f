"""`rodwnl reproduce`: the paper's numeric tables, equations and figures, made anew."""

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from rodwnl.errors import InputError
from rodwnl.options import Digits, Json, read_digits
from rodwnl.output import complex_number, number, print_json, print_table

if TYPE_CHECKING:
    from rodwnl.reproduction import Reproduction, Rows
    from rodwnl.tables import Cell, PrintedRow

_MARKS = {"numeric": "", "erratum": " (erratum)", "differs": " (DIFFERS)"}


def command(
    out: Annotated[Path | None, typer.Option(metavar="FOLDER", help="Default: reproduction.")] = None,
    tables: Annotated[bool, typer.Option("--tables", help="Print the tables only; write nothing.")] = False,
    quick: Annotated[
        bool, typer.Option("--quick", help="Fewer simulations in the figure of theory and simulation.")
    ] = False,
    json: Json = False,
    digits: Digits = None,
) -> int:
    """Everything the paper's numbers rest on, made anew into one folder with an index page.

    The tables, cell by cell, beside computed values at the printed precision; every equation, decided; every
    figure, with its data. A cell that does not hold is shown with more digits and with the value of an
    independent computation. The exit code is 1 if such a cell is not a reviewed erratum, if an erratum no
    longer holds, or if an equation differs.
    """
    from rodwnl.reproduction import prepare, tables_document
    from rodwnl.tables import compared_rows

    if tables and (quick or out is not None):
        raise InputError("--tables writes nothing: leave --out and --quick away")
    wanted = read_digits(digits)
    folder = out or Path("reproduction")
    if not tables:
        prepare(folder)
    rows = compared_rows()
    exact = [] if wanted is None else _exact_entries([row for row, _ in rows], wanted)
    if not json:
        _print_tables(rows, exact)
    elif tables:
        print_json(tables_document(rows, exact))
    if tables:
        return 1 if any(cell.status == "differs" for _, cells in rows for cell in cells) else 0
    return _make(folder, exact, quick, json)


def _make(folder: Path, exact: list[dict[str, Any]], quick: bool, json: bool) -> int:
    from rodwnl.progress import progress
    from rodwnl.reproduction import LEFT_OUT, document, reproduce

    with progress() as watch:
        made = reproduce(folder, exact, watch, quick)
    if json:
        print_json(document(made))
    else:
        _print_rest(made)
        if quick:
            print(f"--quick: {LEFT_OUT}.")
    return 1 if made.differs else 0


def _print_rest(made: "Reproduction") -> None:
    """The ledger in a line, what does not hold in it, and where everything stands."""
    from rodwnl.reproduction import INDEX, LEDGER

    counts = made.report.counts
    print(f"equations: {', '.join(f'{count} {status}' for status, count in counts.items())}")
    for finding in made.report.findings:
        if finding.row.status in ("differs", "not decided"):
            print(f"{finding.label} {finding.row.status}: {finding.row.reason}")
    print(f"{len(made.figures)} figures: {', '.join(figure.name for figure in made.figures)}")
    print(f"wrote {made.folder / INDEX} and {made.folder / LEDGER}")


def _print_tables(rows: "Rows", exact: list[dict[str, Any]]) -> None:
    from rodwnl.reproduction import count_cells

    cells = [cell for _, row_cells in rows for cell in row_cells]
    for table in dict.fromkeys(row.table for row, _ in rows):
        _print_one(table, [(row, row_cells) for row, row_cells in rows if row.table == table])
    _print_exceptions([cell for cell in cells if cell.status != "numeric"])
    for entry in exact:
        _print_exact(entry)
    print(", ".join(f"{count} {status}" for status, count in count_cells(cells).items()), flush=True)


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
