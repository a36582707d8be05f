"""How a language writes each kind of node: one table a language, one function that reads the tables."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field

from derivation.emit.nodes import (
    Call,
    Imaginary,
    Integer,
    Name,
    Negative,
    Node,
    Power,
    Product,
    Quotient,
    Sum,
)

SUM, PRODUCT, POWER, ATOM = range(4)  # how tightly a piece of text binds

BINDS: Mapping[type, int] = {Negative: SUM, Sum: SUM, Product: PRODUCT, Quotient: PRODUCT, Power: POWER}


@dataclass(frozen=True)
class Notation:
    """Templates of one language. A part that binds less tightly than its place asks for gets brackets."""

    imaginary: str
    times: str = "*"
    quotient: tuple[str, int, int] = ("{}/{}", PRODUCT, POWER)
    power: tuple[str, int] = ("{}**{}", ATOM)
    squares: bool = False
    """Spell a higher power of a name as a product of its squares."""
    conjugate: tuple[str, int] = ("{}.conjugate()", ATOM)
    call: str = "{}({})"
    functions: Mapping[str, str] = field(default_factory=dict)
    brackets: str = "({})"
    name: Callable[[str], str] = str
    """How the language spells a name."""
    integer: Callable[[int], str] = str
    """How it spells a whole number that is not an exponent."""


def expression(node: Node, notation: Notation) -> str:
    """The node in the given language, on one line."""

    def part(node: Node, place: int) -> str:
        return _placed(node, place, notation)

    match _in_squares(node, notation):
        case Name(text):
            return notation.name(text)
        case Integer(value):
            return notation.integer(value)
        case Imaginary():
            return notation.imaginary
        case Negative(operand):
            return "-" + part(operand, PRODUCT)
        case Sum():
            return "".join(terms(node, notation))
        case Product(factors):
            return notation.times.join(part(factor, PRODUCT) for factor in factors)
        case Quotient(numerator, denominator):
            template, above, below = notation.quotient
            return template.format(part(numerator, above), part(denominator, below))
        case Power(base, exponent):
            template, place = notation.power
            return template.format(part(base, place), exponent)
        case Call("conjugate", operand):
            template, place = notation.conjugate
            return template.format(part(operand, place))
        case Call(function, operand):
            return notation.call.format(notation.functions.get(function, function), part(operand, SUM))
    raise TypeError(f"no notation for {node!r}")


def rows(node: Node, notation: Notation, width: int) -> list[str]:
    """The node on as many lines as needed: a sum is broken between its terms, so brackets stay whole."""
    lines = [""]
    for term in terms(node, notation):
        if lines[-1] and len(lines[-1] + term) > width:
            lines.append(term.lstrip())
        else:
            lines[-1] += term
    return lines


def terms(node: Node, notation: Notation) -> list[str]:
    """The terms of a sum with their signs; of anything else the one term."""
    if not isinstance(node, Sum):
        return [expression(node, notation)]
    first, *others = node.terms
    return [_placed(first, SUM, notation)] + [
        " - " + _placed(term.operand, PRODUCT, notation)
        if isinstance(term, Negative)
        else " + " + _placed(term, PRODUCT, notation)
        for term in others
    ]


def _placed(node: Node, place: int, notation: Notation) -> str:
    node = _in_squares(node, notation)
    text = expression(node, notation)
    return text if BINDS.get(type(node), ATOM) >= place else notation.brackets.format(text)


def _in_squares(node: Node, notation: Notation) -> Node:
    match node:
        case Power(Name() as base, exponent) if notation.squares and exponent > 2:
            return Product((Power(base, 2),) * (exponent // 2) + (base,) * (exponent % 2))
    return node


def camel_case(name: str) -> str:
    """Theta_bar_u as thetaBarU: in Mathematica an underscore is a pattern, and capitals begin its names."""
    first, *others = name.split("_")
    return first[:1].lower() + first[1:] + "".join(part[:1].upper() + part[1:] for part in others)


TEXT = Notation(imaginary="i", times=" ", power=("{}^{}", ATOM), conjugate=("conj({})", SUM))

LATEX = Notation(
    imaginary=r"\mathrm{i}",
    times=r"\,",
    quotient=(r"\frac{{{}}}{{{}}}", SUM, SUM),
    power=("{{{}}}^{{{}}}", ATOM),
    conjugate=(r"\overline{{{}}}", SUM),
    call=r"{}\left({}\right)",
    functions={
        "sin": r"\sin",
        "cos": r"\cos",
        "exp": r"\exp",
        "log": r"\log",
        "sqrt": r"\operatorname{sqrt}",
    },
    brackets=r"\left({}\right)",
)

# On a numpy array x**2 costs what x*x costs, and x**3 costs 3 to 8 times what x**2*x costs.
PYTHON = Notation(imaginary="1j", call="xp.{}({})", squares=True)

JAX = Notation(imaginary="1j", call="jnp.{}({})", squares=True)

# Spaces, because a number directly before a bracket or a name is a product of its own in Julia.
JULIA = Notation(
    imaginary="im",
    times=" * ",
    quotient=("{} / {}", PRODUCT, POWER),
    power=("{}^{}", ATOM),
    conjugate=("conj({})", SUM),
)

# C has no powers: a small function of the header multiplies. The functions are those of <tgmath.h>. Its whole
# numbers overflow.
C = Notation(
    imaginary="I",
    power=("rodwnl_power({}, {})", SUM),
    conjugate=("conj({})", SUM),
    integer=lambda value: str(value) if value < 10**4 else f"{value}.0",
)

MATHEMATICA = Notation(
    imaginary="I",
    power=("{}^{}", ATOM),
    conjugate=("Conjugate[{}]", SUM),
    call="{}[{}]",
    functions={"sin": "Sin", "cos": "Cos", "exp": "Exp", "log": "Log", "sqrt": "Sqrt"},
    name=camel_case,
)
