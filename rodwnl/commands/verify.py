"""`rodwnl verify`: a paper's equations, each decided exactly, and the cells of its tables."""

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from rodwnl.errors import shown
from rodwnl.options import Json
from rodwnl.output import print_json, print_table

if TYPE_CHECKING:
    from derivation.paper.verify import Finding
    from rodwnl.tables import Cell
    from rodwnl.verification import Report


def command(
    tex: Annotated[
        Path | None,
        typer.Option(metavar="FILE", help="LaTeX source to read. Default: the paper's equations."),
    ] = None,
    notation: Annotated[
        Path | None, typer.Option(metavar="FILE", help="TOML file: which letter means which quantity.")
    ] = None,
    model: Annotated[
        str | None, typer.Option(metavar="NAME|FILE", help="The rod to check against. Default: follower.")
    ] = None,
    only: Annotated[
        str | None, typer.Option(metavar="LABEL", help="Decide this equation, display or table alone.")
    ] = None,
    show: Annotated[
        str | None,
        typer.Option(metavar="LABEL", help="Print what was read, derived and found of an equation."),
    ] = None,
    html: Annotated[
        Path | None, typer.Option(metavar="FILE", help="Write the whole ledger as one page.")
    ] = None,
    json: Json = False,
) -> int:
    """Decide every equation of a LaTeX source: it follows from the exact kinematics, or how it fails to.

    Exit code 1 if an equation, or a table cell that is not a reviewed erratum, differs.
    """
    from rodwnl.storage import require_apart, require_writable
    from rodwnl.verification import check, document

    if html is not None:
        require_apart(html, tex, notation, model)
        require_writable(html)
    report = check(tex, notation, only or show, model)
    if json:
        print_json(document(report))
    elif show:
        for finding in report.findings:
            _print_details(finding, report)
        _print_cells(report.cells)
    else:
        _print_ledger(report)
    if html is not None:
        from rodwnl.ledgerpage import write_page

        write_page(html, report)
    return 1 if report.differs else 0


def _print_ledger(report: "Report") -> None:
    """Counts by part of the theory, then whatever does not hold."""
    from derivation.paper.kinds import GROUPS
    from rodwnl.verification import STATUSES

    lines = []
    for group in GROUPS:
        rows = [f for f in report.findings if f.group == group]
        if rows:
            lines.append([group, *(str(sum(f.row.status == s for f in rows)) for s in STATUSES)])
    lines.append(["all", *map(str, report.counts.values())])
    print_table(["equations", *STATUSES], lines, title=shown(report.source))
    tables = dict.fromkeys(c.table for c in report.cells)
    if tables:
        cells: dict[str, list[str]] = {t: [c.status for c in report.cells if c.table == t] for t in tables}
        print_table(
            ["cells", *report.cell_counts],
            [[shown(t), *(str(found.count(s)) for s in report.cell_counts)] for t, found in cells.items()],
        )
    for finding in report.findings:
        if finding.row.status in ("differs", "not decided"):
            _print_details(finding, report)
    _print_cells(tuple(c for c in report.cells if c.status == "differs"))
    print("rodwnl verify --show LABEL explains a row, --json and --html FILE hold all of them.")


def _print_details(f: "Finding", report: "Report") -> None:
    from derivation.paper.typeset import latex
    from rodwnl.verification import effect_sentence

    e = f.row.equation
    said = {
        "printed": e.latex,
        "read as": f.theirs,
        "because": f.row.reason,
        "derived": latex(f.derived) if f.derived else "",
        "difference": f.difference if f.row.difference else "",
        "edit": f.repair.text
        if f.repair
        else "none of the single edits tried makes it hold" * (f.row.status == "differs"),
        "then": f.repair.latex if f.repair else "",
        "effect": effect_sentence(report.effects.get(e.label)),
        "stage": f.stage,
    }
    print(f"{shown(e.label)}, line {e.line}: {f.row.status}")
    for name, text in said.items():
        if text:
            print(f"  {name:<11}{shown(text)}")
    print()


def _print_cells(cells: "tuple[Cell, ...]") -> None:
    for c in cells:
        method = f" ({c.method})" if c.method else ""
        remark = f"; {c.remark}" if c.remark else ""
        print(
            shown(f"{c.table} {c.row} {c.column}{method}: {c.status}; printed {c.printed}, ")
            + f"computed {c.computed}, independent value agrees to {c.agreement} digits{remark}"
        )
