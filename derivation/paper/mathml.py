"""Syntax trees as MathML, which browsers show without any library."""

from __future__ import annotations

from html import escape

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
from derivation.paper.typeset import ATOM, PRODUCT, SCRIPT, SUM, number_text

GREEK = {
    "alpha": "α", "beta": "β", "gamma": "γ", "delta": "δ", "epsilon": "ϵ", "varepsilon": "ε", "zeta": "ζ",
    "eta": "η", "theta": "θ", "iota": "ι", "kappa": "κ", "lambda": "λ", "mu": "μ", "nu": "ν", "xi": "ξ",
    "pi": "π",
    "rho": "ρ", "sigma": "σ", "tau": "τ", "upsilon": "υ", "phi": "ϕ", "varphi": "φ", "chi": "χ", "psi": "ψ",
    "omega": "ω", "Gamma": "Γ", "Delta": "Δ", "Theta": "Θ", "Lambda": "Λ", "Xi": "Ξ", "Pi": "Π", "Sigma": "Σ",
    "Upsilon": "Υ", "Phi": "Φ", "Psi": "Ψ", "Omega": "Ω", "ell": "ℓ",
}  # fmt: skip
SCRIPT_LETTERS = dict(zip("AFGLMOTU", "𝒜ℱ𝒢ℒℳ𝒪𝒯𝒰", strict=True))
RELATIONS = {"=": "=", "equiv": "≡", "simeq": "≃", "to": "→"}
RESTS = {"cc": "c.c.", "nst": "n.s.t.", "dots": "⋯"}
OVER = {"tilde": "~", "bar": "¯", "hat": "^", "vec": "→", "dot": "˙", "overline": "¯", "widetilde": "~"}


def mathml(node: Node, display: str = "block") -> str:
    """A whole formula; ``display`` is block or inline."""
    return f'<math display="{display}">{_shown(node)}</math>'


def _shown(node: Node, level: int = SUM) -> str:
    text, own = _markup(node)
    return text if own >= level else f"<mrow><mo>(</mo>{text}<mo>)</mo></mrow>"


def _row(*parts: str) -> str:
    return f"<mrow>{''.join(parts)}</mrow>"


def _op(text: str) -> str:
    return f"<mo>{escape(text)}</mo>"


def _bracket(text: str) -> str:
    """A bracket that keeps its size."""
    return f'<mo stretchy="false">{text}</mo>'


def _script(base: str, sub: str = "", sup: str = "") -> str:
    if sub and sup:
        return f"<msubsup>{base}<mrow>{sub}</mrow><mrow>{sup}</mrow></msubsup>"
    if sub or sup:
        tag = "msub" if sub else "msup"
        return f"<{tag}>{base}<mrow>{sub or sup}</mrow></{tag}>"
    return base


def _markup(node: Node) -> tuple[str, int]:
    match node:
        case Num(value):
            return f"<mn>{'∞' if value is None else number_text(value)}</mn>", ATOM
        case Sym():
            return _symbol(node), SCRIPT if node.order else ATOM
        case Sum(terms):
            return _sum(terms), SUM
        case Neg(arg):
            return _row(_op("−"), _shown(arg, PRODUCT)), PRODUCT
        case Prod(factors):
            return _row("<mspace width='0.12em'/>".join(_shown(f, SCRIPT) for f in factors)), PRODUCT
        case Dot(left, right):
            return _row(_shown(left, SCRIPT), _op("⋅"), _shown(right, SCRIPT)), PRODUCT
        case Quot(num, den):
            return f"<mfrac><mrow>{_shown(num)}</mrow><mrow>{_shown(den)}</mrow></mfrac>", ATOM
        case Power(base, exponent):
            return _script(_scripted(base), sup=_shown(exponent)), SCRIPT
        case Prime(arg, n):
            return _script(_scripted(arg), sup=_op("′" * n)), ATOM
        case Conj(Prime(arg, n)):
            return _script(_scripted(arg), sup=_op("′" * n) + _op("*")), ATOM
        case Conj(arg):
            return _script(_scripted(arg), sup=_op("*")), SCRIPT
        case Dagger(arg):
            return _script(_scripted(arg), sup=_op("†")), SCRIPT
        case Abs(arg):
            return _row(_op("|"), _shown(arg), _op("|")), ATOM
        case Func(name, arg):
            return _function(name, arg)
        case Diff():
            return _derivative(node)
        case Int(arg, var, lower, upper):
            limits = f"<msubsup>{_op('∫')}<mrow>{_shown(lower)}</mrow><mrow>{_shown(upper)}</mrow></msubsup>"
            return _row(
                limits,
                "<mi mathvariant='normal'>d</mi>",
                _symbol(var),
                "<mspace width='0.2em'/>",
                _shown(arg),
            ), SUM
        case Series(arg, index, lower, upper):
            below = _row(_symbol(index), _op("="), _shown(lower))
            return _row(
                f"<munderover>{_op('∑')}{below}<mrow>{_shown(upper)}</mrow></munderover>",
                _shown(arg, PRODUCT),
            ), PRODUCT
        case Apply(fn, args):
            inside = _op(",").join(_shown(a) for a in args)
            return _row(_shown(fn, SCRIPT), _bracket("("), inside, _bracket(")")), ATOM
        case At(arg, place):
            return _script(_row(_shown(arg, PRODUCT), _op("|")), sub=_shown(place)), ATOM
        case Matrix(rows):
            cells = "".join(
                "<mtr>" + "".join(f"<mtd>{_shown(e)}</mtd>" for e in row) + "</mtr>" for row in rows
            )
            return _row(_op("["), f"<mtable>{cells}</mtable>", _op("]")), ATOM
        case Tuple(items, weight):
            inside = _row(_bracket("("), _op(",").join(_shown(i) for i in items), _bracket(")"))
            return (inside if weight is None else _script(inside, sub=_shown(weight))), ATOM
        case Rest(kind):
            return f"<mtext>{RESTS[kind]}</mtext>", ATOM
        case Relation(op, left, right):
            return _row(_shown(left), _op(RELATIONS[op]), _shown(right)), SUM
    raise TypeError(f"{node!r} is not a syntax tree")


def _sum(terms: tuple[Expr, ...]) -> str:
    parts = []
    for k, term in enumerate(terms):
        negative = isinstance(term, Neg)
        if negative or k:
            parts.append(_op("−" if negative else "+"))
        parts.append(_shown(term.arg if isinstance(term, Neg) else term, PRODUCT))
    return _row(*parts)


def _scripted(node: Node) -> str:
    return _shown(node, ATOM)


def _function(name: str, arg: Expr) -> tuple[str, int]:
    if name == "exp":
        return _script("<mi mathvariant='normal'>e</mi>", sup=_shown(arg)), SCRIPT
    if name == "sqrt":
        return f"<msqrt>{_shown(arg)}</msqrt>", ATOM
    simple = isinstance(arg, (Sym, Conj, Apply))
    around = _bracket if simple else _op
    inside = _shown(arg) if isinstance(arg, Tuple) else _row(around("("), _shown(arg), around(")"))
    return _row(f"<mi>{name}</mi>", inside), SCRIPT


def _derivative(node: Diff) -> tuple[str, int]:
    power = f"<mn>{node.n}</mn>" if node.n > 1 else ""
    if node.partial:
        operator = _script(_op("∂"), sub=_symbol(node.var), sup=power)
        return (operator if node.arg is None else _row(operator, _shown(node.arg, SCRIPT))), SCRIPT
    d = _script("<mi mathvariant='normal'>d</mi>", sup=power)
    below = _row("<mi mathvariant='normal'>d</mi>", _script(_symbol(node.var), sup=power))
    if node.arg is None or not isinstance(node.arg, Sym):
        fraction = f"<mfrac>{d}{below}</mfrac>"
        return (
            fraction if node.arg is None else _row(fraction, _op("("), _shown(node.arg), _op(")"))
        ), SCRIPT
    return f"<mfrac>{_row(d, _symbol(node.arg))}{below}</mfrac>", ATOM


def _symbol(s: Sym) -> str:
    order = f"<mrow>{_bracket('(')}<mn>{escape(s.order)}</mn>{_bracket(')')}</mrow>" if s.order else ""
    return _script(_letter(s.base), sub=_subscript(s.sub), sup=order)


def _letter(base: str) -> str:
    r"""``\tilde{\mathcal{F}}`` from the outside in."""
    if base.startswith("\\") and base.endswith("}"):
        accent, _, inner = base[1:-1].partition("{")
        if accent == "mathcal":
            return f"<mi>{escape(SCRIPT_LETTERS.get(inner, inner))}</mi>"
        if accent == "mathrm":
            return f"<mi mathvariant='normal'>{escape(inner)}</mi>"
        if accent in OVER:
            return f"<mover accent='true'>{_letter(inner)}{_op(OVER[accent])}</mover>"
        return f"<mi style='font-weight: bold'>{escape(GREEK.get(inner[1:], inner))}</mi>"
    return f"<mi>{escape(GREEK.get(base[1:], base) if base.startswith(chr(92)) else base)}</mi>"


def _subscript(sub: str) -> str:
    if not sub:
        return ""
    if sub.startswith("\\mathrm{"):
        return _letter(sub)
    letters = sub.split("\\")
    head = [f"<mi>{escape(letters[0])}</mi>"] if letters[0] else []
    return "".join([*head, *(f"<mi>{escape(GREEK.get(x, x))}</mi>" for x in letters[1:])])
