"""The arithmetic that a printer sees: nine kinds of node, frozen, compared by value, free of SymPy."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from functools import reduce
from operator import add, mul
from typing import Any


@dataclass(frozen=True)
class Name:
    text: str


@dataclass(frozen=True)
class Integer:
    value: int  # never negative: a minus sign is a Negative


@dataclass(frozen=True)
class Imaginary:
    """The imaginary unit. `1j` is exact on every complex number type; an argument that holds i is plainer."""


@dataclass(frozen=True)
class Negative:
    operand: Node


@dataclass(frozen=True)
class Sum:
    terms: tuple[Node, ...]


@dataclass(frozen=True)
class Product:
    factors: tuple[Node, ...]


@dataclass(frozen=True)
class Quotient:
    numerator: Node
    denominator: Node


@dataclass(frozen=True)
class Power:
    base: Node
    exponent: int  # 2 or more


@dataclass(frozen=True)
class Call:
    """A function of one argument: `conjugate`, or one of the functions that need a namespace."""

    function: str
    operand: Node


KINDS = ("additions", "multiplications", "divisions", "conjugations", "function calls")

Node = Name | Integer | Imaginary | Negative | Sum | Product | Quotient | Power | Call


def children(node: Node) -> tuple[Node, ...]:
    match node:
        case Negative(operand) | Call(_, operand) | Power(operand, _):
            return (operand,)
        case Sum(parts) | Product(parts):
            return parts
        case Quotient(numerator, denominator):
            return numerator, denominator
    return ()


def walk(node: Node) -> Iterator[Node]:
    """The node and everything below it."""
    yield node
    for child in children(node):
        yield from walk(child)


def operations(nodes: Iterable[Node]) -> Counter[str]:
    """Arithmetic operations by kind; x**n counts as n-1 multiplications, a change of sign as nothing."""
    count = Counter(dict.fromkeys(KINDS, 0))
    for node in (part for root in nodes for part in walk(root)):
        match node:
            case Sum(terms):
                count["additions"] += len(terms) - 1
            case Product(factors):
                count["multiplications"] += len(factors) - 1
            case Power(_, exponent):
                count["multiplications"] += exponent - 1
            case Quotient():
                count["divisions"] += 1
            case Call("conjugate", _):
                count["conjugations"] += 1
            case Call():
                count["function calls"] += 1
    return count


def evaluate(node: Node, values: Mapping[str, Any], xp: Any = None) -> Any:
    """The node's value, on whatever numbers `values` holds; functions are looked up in `xp`."""
    match node:
        case Name(text):
            return values[text]
        case Integer(value):
            return value
        case Imaginary():
            return 1j
        case Negative(operand):
            return -evaluate(operand, values, xp)
        case Sum(parts):
            return reduce(add, (evaluate(part, values, xp) for part in parts))
        case Product(parts):
            return reduce(mul, (evaluate(part, values, xp) for part in parts))
        case Quotient(numerator, denominator):
            return evaluate(numerator, values, xp) / evaluate(denominator, values, xp)
        case Power(base, exponent):
            return evaluate(base, values, xp) ** exponent
        case Call("conjugate", operand):
            return evaluate(operand, values, xp).conjugate()
        case Call(function, operand):
            return getattr(xp, function)(evaluate(operand, values, xp))
