"""Syntax trees as LaTeX (which reads back to the same tree), and algebra as syntax trees."""

from __future__ import annotations

from fractions import Fraction
from typing import Any

from derivation.paper.algebra import Atom, Monomial, Poly
from derivation.paper.letters import SCALED
from derivation.paper.notation import Notation
from derivation.paper.syntax import (
    Abs,
    Apply,
    At,
    Conj,
    Dagger,
    Diff,
    Dot,
    Expr,
    Func,
    Int,
    Matrix,
    Neg,
    Node,
    Num,
    Power,
    Prime,
    Prod,
    Quot,
    Relation,
    Rest,
    Series,
    Sum,
    Sym,
    Tuple,
)
from derivation.paper.tokens import GREEK
from derivation.symbols import latex_of

SUM, PRODUCT, SCRIPT, ATOM = range(4)
RELATIONS = {"=": "=", "equiv": r"\equiv", "simeq": r"\simeq", "to": r"\to"}
RESTS = {"cc": r"\mathrm{c.c.}", "nst": r"\mathrm{n.s.t.}", "dots": r"\cdots"}
ONE = Num(Fraction(1))


def latex(node: Node, level: int = SUM) -> str:
    """LaTeX of a node, in brackets where it stands in a place that binds more tightly than itself."""
    text, own = _latex(node)
    return text if own >= level else rf"\left({text}\right)"


def _latex(node: Node) -> tuple[str, int]:
    match node:
        case Num(None):
            return r"\infty", ATOM
        case Num(value) if value is not None:
            return _number(value)
        case Sym(_, _, order):
            return node.name + (f"^{{({order})}}" if order else ""), SCRIPT if order else ATOM
        case Sum(terms):
            return _sum(terms), SUM
        case Neg(arg):
            return f"-{latex(arg, PRODUCT)}", SUM
        case Prod(factors):
            return " ".join(_factor(f, k == len(factors) - 1) for k, f in enumerate(factors)), PRODUCT
        case Dot(left, right):
            return rf"{latex(left, SCRIPT)}\cdot {latex(right, SCRIPT)}", PRODUCT
        case Quot(num, den):
            return rf"\frac{{{latex(num)}}}{{{latex(den)}}}", ATOM
        case Power(base, exponent):
            return f"{_scripted(base)}^{{{latex(exponent)}}}", SCRIPT
        case Prime(arg, n):
            return f"{latex(arg, SCRIPT if isinstance(arg, Sym) else ATOM)}{chr(39) * n}", ATOM
        case Conj(arg):
            return f"{_scripted(arg)}^*", SCRIPT
        case Dagger(arg):
            return rf"{_scripted(arg)}^\dagger", SCRIPT
        case Abs(arg):
            return f"|{latex(arg)}|", ATOM
        case Func(name, arg):
            return _function(name, arg)
        case Diff():
            return _derivative(node)
        case Int(arg, var, lower, upper):
            limits = rf"_{{{latex(lower)}}}^{{{latex(upper)}}}"
            return rf"\int{limits} \mathrm{{d}}{latex(var)}\, {latex(arg)}", SUM
        case Series(arg, index, lower, upper):
            return (
                rf"\sum_{{{latex(index)}={latex(lower)}}}^{{{latex(upper)}}} {latex(arg, PRODUCT)}",
                PRODUCT,
            )
        case Apply(fn, args):
            return f"{_called(fn)}({', '.join(map(latex, args))})", ATOM
        case At(arg, place):
            return rf"\left. {latex(arg, PRODUCT)} \right|_{{{latex(place)}}}", ATOM
        case Matrix(rows):
            inside = r" \\ ".join(" & ".join(map(latex, row)) for row in rows)
            return rf"\begin{{bmatrix}} {inside} \end{{bmatrix}}", ATOM
        case Tuple(items, weight):
            inside = f"({', '.join(map(latex, items))})"
            return (inside if weight is None else f"{inside}_{{{latex(weight)}}}"), ATOM
        case Rest(kind):
            return RESTS[kind], ATOM
        case Relation(op, left, right):
            return f"{latex(left)} {RELATIONS[op]} {latex(right)}", SUM
    raise TypeError(f"{node!r} is not a syntax tree")


def _number(value: Fraction) -> tuple[str, int]:
    if value.denominator == 1 or (value * 10**12).denominator == 1:
        return number_text(value), ATOM
    return rf"\frac{{{value.numerator}}}{{{value.denominator}}}", ATOM


def number_text(value: Fraction) -> str:
    """A number as it is printed: an integer, a decimal fraction, or a quotient."""
    if value.denominator == 1:
        return str(value)
    scaled = value * 10**12
    if scaled.denominator == 1:
        return f"{float(value):.12f}".rstrip("0")
    return f"{value.numerator}/{value.denominator}"


def _sum(terms: tuple[Expr, ...]) -> str:
    text = ""
    for k, term in enumerate(terms):
        negative = isinstance(term, Neg)
        body = latex(term.arg if isinstance(term, Neg) else term, PRODUCT)
        text += ("-" if negative else "") + body if k == 0 else (" - " if negative else " + ") + body
    return text


def _factor(node: Expr, last: bool) -> str:
    if (not last and isinstance(node, (Series, Func))) or (isinstance(node, Diff) and not last):
        return latex(node, ATOM) if isinstance(node, Series) else _latex(node)[0]
    return latex(node, SCRIPT)


def _scripted(node: Node) -> str:
    """What a script stands on: a letter, a call, a primed letter, or brackets."""
    if isinstance(node, Prime) and isinstance(node.arg, Sym):
        return _latex(node)[0]
    return latex(node, ATOM)


def _called(fn: Node) -> str:
    """The function of a call; a star needs no brackets there."""
    return _latex(fn)[0] if isinstance(fn, Conj) and isinstance(fn.arg, (Sym, Prime)) else _scripted(fn)


def _function(name: str, arg: Expr) -> tuple[str, int]:
    if name == "exp":
        return f"e^{{{latex(arg)}}}", SCRIPT
    if name == "sqrt":
        return rf"\sqrt{{{latex(arg)}}}", ATOM
    operator = rf"\{name}" if name in ("cos", "sin") else rf"\mathrm{{{name}}}"
    if isinstance(arg, Tuple):
        return f"{operator}{latex(arg)}", SCRIPT
    return rf"{operator}\left({latex(arg)}\right)", SCRIPT


def _derivative(node: Diff) -> tuple[str, int]:
    power = f"^{{{node.n}}}" if node.n > 1 else ""
    if node.partial:
        operator = rf"\partial_{{{latex(node.var)}}}{power}"
        return (operator if node.arg is None else f"{operator} {latex(node.arg, SCRIPT)}"), SCRIPT
    below = rf"\mathrm{{d}}{latex(node.var)}{power}"
    if node.arg is None or not isinstance(node.arg, Sym):
        above = rf"\frac{{\mathrm{{d}}{power}}}{{{below}}}"
        return (above if node.arg is None else rf"{above}\left({latex(node.arg)}\right)"), SCRIPT
    return rf"\frac{{\mathrm{{d}}{power}{latex(node.arg)}}}{{{below}}}", ATOM


# Algebra --------------------------------------------------------------------------------------------------

#: Letters of what the algebra holds and a notation may not name.
OTHERS = {
    "omega": r"\omega_c", "omega_branch": r"\omega", "lambda_F": r"\lambda_{F}", "gamma2": r"\gamma_2",
    "k3": "k_3", "step": r"\delta", "phase_0": r"\phi", "alpha_re": r"\alpha_r", "alpha_im": r"\alpha_i",
    "beta_re": r"\beta_r", "beta_im": r"\beta_i", "L": "L",
}  # fmt: skip


def tree(p: Poly, notation: Notation) -> Expr:
    """A polynomial as a syntax tree in a paper's letters, its terms in a fixed order."""
    terms = [_term(m, c, notation) for m, c in sorted(p.terms.items(), key=lambda t: _rank(t[0]))]
    return terms[0] if len(terms) == 1 else Sum(tuple(terms)) if terms else Num(Fraction(0))


def formula(p: Poly, notation: Notation) -> str:
    """A polynomial as LaTeX."""
    return latex(tree(p, notation))


def _rank(m: Monomial) -> tuple[int, list[str]]:
    return sum(abs(e) for _, e in m), sorted(f"{a!r}^{e}" for a, e in m)


def _term(m: Monomial, c: Any, notation: Notation) -> Expr:
    """A rational times i or 1, constants before functions, what has a negative power below the line."""
    re_, im = (
        Fraction(int(c.x.numerator), int(c.x.denominator)),
        Fraction(int(c.y.numerator), int(c.y.denominator)),
    )
    if re_ and im:
        first = _term(m, type(c)(c.x, 0), notation)
        second = _term(m, type(c)(0, c.y), notation)
        return Sum((first, second))
    value, unit = (im, [Sym("i")]) if im else (re_, [])
    ordered = sorted(m, key=lambda pair: (pair[0].kind != "constant", repr(pair[0])))
    above = [*unit, *(_power(a, e, notation) for a, e in ordered if e > 0)]
    below = [_power(a, -e, notation) for a, e in ordered if e < 0]
    if abs(value.numerator) != 1 or not above:
        above.insert(0, Num(Fraction(abs(value.numerator))))
    if value.denominator != 1:
        below.insert(0, Num(Fraction(value.denominator)))
    body: Expr = _product(above)
    if below:
        scalars = [f for f in above if _is_constant(f)]
        functions = [f for f in above if not _is_constant(f)]
        quotient = Quot(_product(scalars or [ONE]), _product(below))
        body = _product([quotient, *functions])
    return Neg(body) if value < 0 else body


def _is_constant(node: Expr) -> bool:
    return isinstance(node, Num) or (isinstance(node, Sym) and not node.order) or (
        isinstance(node, Power) and _is_constant(node.base)
    )  # fmt: skip


def _product(factors: list[Expr]) -> Expr:
    return factors[0] if len(factors) == 1 else Prod(tuple(factors))


def _power(a: Atom, e: int, notation: Notation) -> Expr:
    base = _atom(a, notation)
    return base if e == 1 else Power(base, Num(Fraction(e)))


def _atom(a: Atom, notation: Notation) -> Expr:
    if a.kind in ("exp", "sqrt"):
        return Func(a.kind, tree(a.arg, notation))
    if a.kind == "integral":
        return Int(tree(a.arg, notation), Sym("u"), Num(Fraction(0)), ONE)
    if a.kind == "inverse":
        return Quot(ONE, tree(a.arg, notation))
    if a.kind == "operator":
        return Diff(None, _letter(a.name, notation), 1, partial=True)
    node: Expr = _letter(a.name, notation, str(a.order) if a.kind == "field" else "")
    if a.kind == "amplitude" and a.slow:
        node = Diff(node, _letter("T", notation), a.slow, partial=False)
    elif a.kind == "shape" and a.u:
        node = Prime(node, a.u)
    else:
        for variable, times in (("t" if a.kind == "exact" else "tau", a.tau), ("T", a.slow), ("u", a.u)):
            if times:
                node = Diff(node, _letter(variable, notation), times, partial=True)
    if a.bar:
        node = Conj(node)
    return node if a.place is None else Apply(node, (Num(Fraction(a.place)),))


def _letter(quantity: str, notation: Notation, order: str = "") -> Sym:
    """A quantity's letter; where the notation has several, the one with an accent (the scaled one)."""
    if quantity in ("cos", "sin"):
        return Sym(rf"\{quantity}\theta")
    scaled = quantity in SCALED
    letters = [x for x, q in notation.symbols.items() if q == quantity]
    letters = [OTHERS[quantity]] if quantity in OTHERS else letters
    if not letters:
        return Sym(_spelled(quantity), "", order)
    base, _, sub = max(letters, key=lambda x: ("\\tilde" in x) == scaled).partition("_")
    return Sym(base, sub.strip("{}") if sub.count("{") < 2 else sub[1:-1], order)


def _spelled(quantity: str) -> str:
    """A quantity of the derivation, or a rod's own parameter, that the notation has no letter for."""
    tex = latex_of(quantity)
    if tex != quantity or len(quantity) == 1:
        return tex
    return f"\\{quantity}" if quantity in GREEK else rf"\mathrm{{{quantity.replace('_', ' ')}}}"
