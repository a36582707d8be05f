"""The reader: displays to equations, equations to syntax trees, errors with their lines."""

from __future__ import annotations

from fractions import Fraction
from pathlib import Path

import pytest

import derivation.paper
from derivation.errors import ReadError
from derivation.paper.notation import load
from derivation.paper.parse import expression, letter_name, parse
from derivation.paper.read import Paper, number, read
from derivation.paper.scan import Cell, scan
from derivation.paper.syntax import (
    Abs,
    Apply,
    Conj,
    Diff,
    Func,
    Int,
    Num,
    Power,
    Prime,
    Prod,
    Quot,
    Relation,
    Sum,
    Sym,
)
from derivation.paper.tokens import MAX_DEPTH, tokenize
from derivation.paper.typeset import latex

NOTATION = load()
BUNDLED = Path(derivation.paper.__file__).with_name("equations.tex")
ONE, TWO = Num(Fraction(1)), Num(Fraction(2))


def of(text: str) -> Paper:
    return read(text, NOTATION)


def labels(text: str) -> list[str]:
    return [e.label for e in of(text).equations]


def expr(latex: str):
    return expression(latex, NOTATION.functions)


def test_every_equation_of_the_bundled_paper_is_read():
    paper = of(BUNDLED.read_text(encoding="utf-8"))
    assert len(paper.equations) == 219
    assert len({e.label for e in paper.equations}) == 219
    assert [t.label for t in paper.tables] == ["tab:summary", "tab:parameters", "tab:beta_check"]
    assert [len(t.rows) for t in paper.tables] == [6, 5, 5]


def test_line_is_where_the_display_begins():
    text = "% a comment\n\n\\begin{equation}\n% x = \\unknown\n  Y = H\n\\label{eq:a}\n\\end{equation}\n"
    assert [(e.label, e.line) for e in of(text).equations] == [("eq:a.1", 3)]


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        (r"\[ Y = H, \quad H = Y \]", ["after start.1", "after start.2"]),
        (r"\begin{equation}Y = H\label{eq:a}\end{equation}\[H = Y\]\[H = Y\]",
         ["eq:a.1", "after eq:a.1", "after eq:a/2.1"]),
        (r"\begin{equation}Y=H\label{eq:a}\end{equation}\begin{equation}H=Y\label{eq:a}\end{equation}",
         ["eq:a.1", "eq:a#2.1"]),
        (r"\begin{align}Y&=H\label{eq:a}\\H&=Y\label{eq:b}\end{align}", ["eq:a.1", "eq:b.1"]),
        (r"\begin{align}Y&=H\nonumber\\H&=Y\label{eq:b}\end{align}", ["eq:b.1", "eq:b.2"]),
        (r"\[ X_0(u), \qquad X_2(u) \]", ["after start.1"]),
    ],
)  # fmt: skip
def test_names(text, expected):
    assert labels(text) == expected


def test_rows_that_continue_are_joined():
    body = [
        e.body for e in of(r"\[\begin{aligned} Y &= H\\ &+ X_0\\ &- X_2\\ H &= Y\end{aligned}\]").equations
    ]
    assert len(body) == 2
    assert body[0] == Relation("=", Sym("Y"), expr("H + X_0 - X_2"))


def test_chains_are_cut():
    first = [e.body for e in of(r"\[Y = H = X_0\]").equations]
    assert first == [Relation("=", Sym("Y"), Sym("H")), Relation("=", Sym("Y"), Sym("X", "0"))]
    zero = Num(Fraction(0))
    second = [e.body for e in of(r"\[Y = H = 0\]").equations]
    assert second == [Relation("=", Sym("Y"), zero), Relation("=", Sym("H"), zero)]


def test_a_place_holds_for_all_equations_before_it():
    equations = of(
        r"\[Y = 0, H = 0, \quad \mathrm{at}\quad u = 0, \\ Y = 1 \quad \mathrm{at}\,\, u=1.\]"
    ).equations
    assert [e.place.right for e in equations] == [Num(Fraction(0)), Num(Fraction(0)), ONE]


def test_a_place_said_in_the_sentence_before():
    (equation,) = of("We have. They hold at $u = 1$ as \\[ Y = 1 \\]").equations
    assert equation.place is None
    assert equation.said == Relation("=", Sym("u"), ONE)


def test_inline_definitions_only_of_the_wanted_letters():
    text = r"Here $\nu=1-\mathcal{F}/k_1$ and $Y = 2$ and $\mu \equiv \tilde k_2\nu + \mathcal F$."
    assert labels(text) == ["inline nu", "inline mu"]


@pytest.mark.parametrize(
    ("latex", "tree"),
    [
        (r"\Theta^* (Y + H)", Prod((Conj(Sym(r"\Theta")), Sum((Sym("Y"), Sym("H")))))),
        (r"\Theta(1)^2", Power(Apply(Sym(r"\Theta"), (ONE,)), TWO)),
        (r"|\Theta'|^2", Power(Abs(Prime(Sym(r"\Theta"), 1)), TWO)),
        (r"\theta^{(1)}(u=1)", Apply(Sym(r"\theta", "", "1"), (Relation("=", Sym("u"), ONE),))),
        (r"\partial_u^2 y^{(1)} H", Prod((Diff(Sym("y", "", "1"), Sym("u"), 2, True), Sym("H")))),
        (r"\frac{\mathrm{dA}}{\mathrm{d}T}", Diff(Sym("A"), Sym("T"), 1, False)),
        (r"\operatorname{Re}(\beta)\Delta", Prod((Func("Re", Sym(r"\beta")), Sym(r"\Delta")))),
        (r"\int_0^1 \mathrm{d}u\, Y + H", Int(Sum((Sym("Y"), Sym("H"))), Sym("u"), Num(Fraction(0)), ONE)),
        (r"\int_0^1 Y \mathrm{d}u", Int(Sym("Y"), Sym("u"), Num(Fraction(0)), ONE)),
        (r"\cos\theta(u, t)", Func("cos", Apply(Sym(r"\theta"), (Sym("u"), Sym("t"))))),
    ],
)  # fmt: skip
def test_trees(latex, tree):
    assert expr(latex) == tree


X2 = Sym("x", "", "2")


@pytest.mark.parametrize(
    ("spellings", "tree"),
    [
        ((r"x^{(2)'}", r"x^{(2)\prime}", r"x^{\prime(2)}", r"x'^{(2)}"), Prime(X2, 1)),
        ((r"x^{\left(2\right)\,'}", r"x^{ ( 2 ) }'"), Prime(X2, 1)),
        ((r"x^{(2)''}", r"x^{(2)\prime\prime}", r"x^{'(2)'}"), Prime(X2, 2)),
        ((r"x^{(2)*}", r"x^{*(2)}", r"x^{(2)\ast}"), Conj(X2)),
        ((r"x^{(2)'*}", r"x^{(2)\prime *}"), Conj(Prime(X2, 1))),
        ((r"Y'^{*}", r"Y^{\prime *}", r"Y^{'*}"), Conj(Prime(Sym("Y"), 1))),
        ((r"Y^{*\prime}", r"Y^{*}'", r"(Y^*)'"), Prime(Conj(Sym("Y")), 1)),
        ((r"Y^\prime", r"Y^{\prime}", "Y'"), Prime(Sym("Y"), 1)),
        ((r"x^{(2)2}", r"{x^{(2)}}^2", r"(x^{(2)})^2"), Power(X2, TWO)),
        ((r"\Psi^*_Y", r"\Psi_Y^*"), Conj(Sym(r"\Psi", "Y"))),
        ((r"h'_1", r"h_1'"), Prime(Sym("h", "1"), 1)),
        ((r"|Y|^{2}", r"|Y|^2"), Power(Abs(Sym("Y")), TWO)),
        ((r"\Theta^2(1)",), Apply(Power(Sym(r"\Theta"), TWO), (ONE,))),
        ((r"\frac12 Y", r"\frac{1}2 Y"), Prod((Quot(ONE, TWO), Sym("Y")))),
        ((r"Y^12", r"Y^{1}2"), Prod((Power(Sym("Y"), ONE), TWO))),
        ((r"\dot{x}^{(2)}",), Sym(r"\dot{x}", "", "2")),
        ((r"e^{(2)}",), Func("exp", TWO)),
    ],
)  # fmt: skip
def test_scripts(spellings, tree):
    assert [expr(s) for s in spellings] == [tree] * len(spellings)


@pytest.mark.parametrize(
    "script",
    [
        "^{(2)+1}", "^{(N)}", "^{(ii)}", "^{(n+1)}", "^{[2]}", "^{2(2)}", r"^{(2)\theta}", "^{2'}", "^2'",
        "^2^3", "^{2*}", "^{1,2}", "^{a=b}", "^{}", "^{+}", "^1.5", "_{(2)}", "_{2'}", "_{a^{(2)}}",
        "_{a+b}", "_1_2",
    ],
)  # fmt: skip
def test_a_script_that_is_not_understood_is_an_error(script):
    with pytest.raises(ReadError, match="line 3: "):
        of(f"\\[\n Y = H +\n x{script} \\]")


def test_an_inverse_function_is_not_taken_for_a_quotient():
    with pytest.raises(ReadError, match="cos to a negative power"):
        expr(r"\cos^{-1}\theta")


@pytest.mark.parametrize("spelling", [r"\tilde{k}_1", r"\tilde k_1", r"\tilde{k}_{1}", r"\tilde{k_1}"])
def test_a_letter_has_one_spelling(spelling):
    assert letter_name(spelling) == r"\tilde{k}_1"


def test_numbers_of_cells_are_exact():
    assert number(Cell(r"$2\times 10^{2}$", 1)) == Prod((TWO, Power(Num(Fraction(10)), TWO)))
    assert number(Cell("6.93+4.13 i", 1)).terms[0] == Num(Fraction(693, 100))


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("\n\\begin{equation}\nY = H\n", r"line 2: .*not closed.*\\end\{equation\}"),
        ("\\[\n\nY = \\frac{1}{2 \\]", r"line 3: \{ is not closed"),
        ("\\[ Y = (H] \\]", r"line 1: \] closes \( of line 1"),
        ("\\[\nY = \\wp \\]", r"line 2: unknown command \\wp"),
        ("\\[\nY = + = H\\]", r"line 2: unexpected '='; expected .*a symbol"),
        ("\\[\nY = \\frac{1} \\]", r"line 2: unexpected the end of the equation"),
        ("\\[ Y = H, \n H + 1 \\]", r"line 2: a formula without a relation"),
        ("\\[ Y = \\int_0^1 H \\]", r"line 1: \\int without d"),
        ("\\[ Y = \\mathrm{Re} \\]", r"line 1: Re without an argument"),
        ("\\[ Y = H^{(1)}{}^{(2)(3)} \\]", r"line 1"),
        ("$ Y = H", r"line 1: .*not closed; expected \$"),
    ],
)  # fmt: skip
def test_a_broken_file_gives_line_and_expectation(text, message):
    with pytest.raises(ReadError, match=message):
        of(text)


def test_size_and_nesting_are_bounded():
    with pytest.raises(ReadError, match=f"nested deeper than {MAX_DEPTH}"):
        of(r"\[Y = " + "(" * 500 + "H" + ")" * 500 + r"\]")
    with pytest.raises(ReadError, match="more than 20000 symbols"):
        of(r"\[Y = " + "H + " * 30_000 + r"H\]")
    with pytest.raises(ReadError, match="at most 4000000"):
        scan("x" * 4_000_001)


def test_what_is_read_is_never_run():
    (equation,) = of(r"\[Y = \mathrm{__import__('os')}\]").equations
    assert equation.body.right == Sym(r"\mathrm{__import__('os')}")


def test_notation_of_another_paper(tmp_path):
    file = tmp_path / "letters.toml"
    file.write_text("[symbols]\n'W' = 'Y'\n[functions]\n'W' = ['s']\n", encoding="utf-8")
    other = load(file)
    assert other.quantity("W") == "Y"
    assert other.quantity(r"\nu") == "nu"
    (chain,) = parse(tokenize("W(s)", 1), other.functions)
    assert chain[1] == Apply(Sym("W"), (Sym("s"),))


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("[symbols\n", "not TOML"),
        ("[letters]\n", "unknown section 'letters'"),
        ("[symbols]\n'W' = 3\n", "must name"),
    ],
)
def test_a_wrong_notation_is_refused(tmp_path, text, message):
    file = tmp_path / "letters.toml"
    file.write_text(text, encoding="utf-8")
    with pytest.raises(ReadError, match=message):
        load(file)


def test_the_columns_of_an_alignat_are_no_mathematics(notation):
    (equation,) = read(r"\begin{alignat*}{2} H(1) &= 0 \end{alignat*}", notation).equations
    assert latex(equation.body) == "H(1) = 0"


def test_a_source_that_goes_on_in_another_file_is_refused(notation):
    text = "\\[ H(1) = 0 \\]\n\\input {more} % \\input{less}\n"
    with pytest.raises(ReadError, match=r"line 2: \\input \{more\}: this file alone is read"):
        read(text, notation)
    assert read(text.replace(r"\input {more}", ""), notation).equations
