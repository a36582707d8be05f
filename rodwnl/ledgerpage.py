"""The ledger as one self-contained page: MathML, a filter by status, details that unfold."""

from __future__ import annotations

from html import escape
from pathlib import Path
from string import Template
from typing import TYPE_CHECKING

from rodwnl.storage import replacing
from rodwnl.verification import CELLS, Report, effect_sentence

if TYPE_CHECKING:
    from derivation.paper.verify import Finding
    from rodwnl.tables import Cell


def write_page(path: Path, report: Report) -> None:
    """Write the page, whole or not at all."""
    text = page(report)
    with replacing(path) as temporary:
        temporary.write_text(text, encoding="utf-8")


def page(report: Report) -> str:
    """The page as HTML."""
    template = Template(Path(__file__).with_name("data").joinpath("ledger.html").read_text(encoding="utf-8"))
    return template.substitute(
        source=escape(report.source),
        buttons="".join(_button(s, n) for s, n in report.counts.items()),
        equations="".join(_equation(f, report) for f in report.findings),
        cells="".join(map(_cell, report.cells)),
        cell_counts=", ".join(f"{report.cell_counts[s]} {s}" for s in CELLS),
        hidden="" if report.cells else "hidden",
    )


def _button(status: str, count: int) -> str:
    return (
        f'<label class="s {_class(status)}"><input type="checkbox" checked data-status="{_class(status)}">'
        f"{status} <b>{count}</b></label>"
    )


def _class(status: str) -> str:
    return status.replace(" ", "-")


def _equation(f: Finding, report: Report) -> str:
    from derivation.paper.mathml import mathml

    e = f.row.equation
    at = f'<span class="at">at {mathml(f.place, display="inline")}</span>' if f.place else ""
    return (
        f'<tr class="row {_class(f.row.status)}" id="{escape(e.label)}">'
        f'<td class="label">{escape(e.label)}<br><small>line {e.line}</small></td>'
        f'<td><span class="s {_class(f.row.status)}">{f.row.status}</span></td>'
        f'<td class="formula">{mathml(e.body)}{at}<details><summary>{escape(f.row.reason)}</summary>'
        f"{_details(f, report)}</details></td></tr>\n"
    )


def _details(f: Finding, report: Report) -> str:
    from derivation.paper.mathml import mathml
    from derivation.paper.typeset import tree

    left = tree(f.row.difference, report.notation) if f.row.difference else None
    entries = {
        "printed": f"<code>{escape(f.row.equation.latex)}</code>",
        "derived": mathml(f.derived) if f.derived else "",
        "difference": mathml(left) if left else "",
        "edit": f"<code>{escape(f.repair.text)}</code>{mathml(f.repair.body)}" if f.repair else "",
        "effect": escape(effect_sentence(report.effects.get(f.label))),
        "comes from": f"<code>{escape(f.stage)}</code>",
    }
    return "<dl>" + "".join(f"<dt>{k}</dt><dd>{v}</dd>" for k, v in entries.items() if v) + "</dl>"


def _cell(c: Cell) -> str:
    method = f" ({c.method})" if c.method else ""
    return (
        f'<tr class="{c.status}"><td>{escape(c.table)} {escape(c.row)}</td>'
        f"<td>{escape(c.column + method)}</td>"
        f'<td><span class="s {c.status}">{c.status}</span></td><td>{escape(c.printed)}</td>'
        f"<td>{escape(c.computed)}</td><td>{_digits(c.value)}</td><td>{_digits(c.independent)}</td>"
        f"<td>{c.agreement}</td></tr>\n"
    )


def _digits(value: complex) -> str:
    if isinstance(value, complex):
        return f"{value.real:.12g} {'-' if value.imag < 0 else '+'} {abs(value.imag):.12g}i"
    return f"{value:.12g}"
