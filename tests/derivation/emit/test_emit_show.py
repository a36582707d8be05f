"""Derived objects for readers: text, LaTeX, Python."""

from __future__ import annotations

from dataclasses import dataclass

import pytest
import sympy

from derivation.emit.show import FORMATS, show

Y, Theta, Theta_bar, k1 = sympy.symbols("Y Theta Theta_bar k1")
LETTERS = {Theta: r"\Theta", Theta_bar: r"\Theta^*", k1: r"\tilde{k}_1", sympy.Symbol("g1"): "g_1"}
EXPR = Theta_bar**2 * Y / (2 * k1) - sympy.I * Theta / 3 + sympy.Rational(1, 2)


def test_one_expression_in_each_format():
    assert show("g1", EXPR) == "g1 = 1/2 - i Theta/3 + Y Theta_bar^2/(2 k1)"
    assert show("g1", EXPR, "python") == "g1 = 1/2 - 1j*Theta/3 + Y*Theta_bar**2/(2*k1)"
    assert show("g1", EXPR, "latex", LETTERS) == (
        r"g_1 = \frac{1}{2} - \frac{\mathrm{i}\,\Theta}{3} + \frac{Y\,{\Theta^*}^{2}}{2\,\tilde{k}_1}"
    )


def test_text_and_python_mean_the_expression():
    text = show("g1", sympy.expand((Y + Theta * k1) ** 4 * (1 - sympy.I / k1)))
    read = text.removeprefix("g1 = ").replace("i ", "I*").replace("\n", " ").replace("^", "**")
    spaced = "*".join(part for part in read.split(" ") if part).replace("*+*", " + ").replace("*-*", " - ")
    assert sympy.expand(sympy.sympify(spaced) - (Y + Theta * k1) ** 4 * (1 - sympy.I / k1)) == 0


def test_records_mappings_matrices_and_ring_elements():
    @dataclass(frozen=True)
    class Forcing:
        g1: object
        parts: dict[str, object]

    ring = sympy.ring("Y,k1", sympy.QQ_I)[0]
    element = ring.from_expr(Y / 3 + k1**2)
    record = Forcing(
        element, {"tip": sympy.Eq(Y, k1), "matrix": sympy.Matrix([[0, Y]]), "order": 2, "note": "odd"}
    )
    assert show("forcing", record).split("\n") == [
        "forcing.g1 = Y/3 + k1^2",
        "forcing.parts.tip: Y = k1",
        "forcing.parts.matrix.11 = 0",
        "forcing.parts.matrix.12 = Y",
        "forcing.parts.order: 2",
        "forcing.parts.note: odd",
    ]


def test_foreign_nodes_are_spelt_by_sympy():
    f = sympy.Function("f")(Y)
    assert show("d", sympy.Derivative(f, Y) * k1 + sympy.pi) == "d = pi + k1 Derivative(f(Y), Y)"
    assert r"\frac{d}{d Y}" in show("d", sympy.Derivative(f, Y), "latex")


@pytest.mark.parametrize("form", FORMATS)
def test_long_expressions_are_broken_between_terms(form):
    lines = show("g", sympy.expand((Y + Theta + k1) ** 6), form, LETTERS).split("\n")
    assert len(lines) > 3
    assert max(map(len, lines)) <= 110
    assert all(line.count("{") == line.count("}") for line in lines if "aligned" not in line)


def test_unknown_format():
    with pytest.raises(ValueError, match="unknown format 'pdf': choose one of text, latex, python"):
        show("g", Y, "pdf")  # type: ignore[arg-type]
