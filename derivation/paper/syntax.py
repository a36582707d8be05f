"""The syntax tree of a printed equation: frozen, hashable, without meaning.

What a symbol stands for is the notation's affair (:mod:`derivation.paper.notation`), what an expression is
worth that of :mod:`derivation.paper.lower`.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, fields
from fractions import Fraction


@dataclass(frozen=True)
class Num:
    r"""A number: ``2``, ``0.01``, and ``\infty`` as None."""

    value: Fraction | None


@dataclass(frozen=True)
class Sym:
    r"""A letter, accents, subscript, order: ``\tilde{\theta}^{(3)}``, ``\mathcal{L}_{\alpha\beta}``."""

    base: str
    sub: str = ""
    order: str = ""

    @property
    def name(self) -> str:
        """The letter in one spelling, without the order: ``\\tilde{k}_1``, ``A_{\\mathrm{tip}}``."""
        return self.base + _subscript(self.sub)


@dataclass(frozen=True)
class Sum:
    """Terms, the negative ones as :class:`Neg`."""

    terms: tuple[Expr, ...]


@dataclass(frozen=True)
class Neg:
    arg: Expr


@dataclass(frozen=True)
class Prod:
    """Factors in their printed order (operators do not commute)."""

    factors: tuple[Expr, ...]


@dataclass(frozen=True)
class Dot:
    """Scalar product of two vectors."""

    left: Expr
    right: Expr


@dataclass(frozen=True)
class Quot:
    num: Expr
    den: Expr


@dataclass(frozen=True)
class Power:
    base: Expr
    exponent: Expr


@dataclass(frozen=True)
class Prime:
    """Derivative of a function of one variable, ``n`` primes."""

    arg: Expr
    n: int


@dataclass(frozen=True)
class Conj:
    arg: Expr


@dataclass(frozen=True)
class Dagger:
    arg: Expr


@dataclass(frozen=True)
class Abs:
    arg: Expr


@dataclass(frozen=True)
class Func:
    """``Re``, ``Im``, ``cos``, ``sin``, ``exp``, ``sqrt`` or ``diag`` (of a :class:`Tuple`)."""

    name: str
    arg: Expr


@dataclass(frozen=True)
class Diff:
    """An ``n``-th derivative; ``arg`` None is the bare operator."""

    arg: Expr | None
    var: Sym
    n: int
    partial: bool


@dataclass(frozen=True)
class Int:
    arg: Expr
    var: Sym
    lower: Expr
    upper: Expr


@dataclass(frozen=True)
class Series:
    r"""``\sum_{index=lower}^{upper} arg``."""

    arg: Expr
    index: Sym
    lower: Expr
    upper: Expr


@dataclass(frozen=True)
class Apply:
    """A function at arguments; an argument may be a :class:`Relation`, ``u = 1``."""

    fn: Expr
    args: tuple[Expr | Relation, ...]


@dataclass(frozen=True)
class At:
    """A value at a place: ``\\left. arg \\right|_{place}``."""

    arg: Expr
    place: Expr | Relation


@dataclass(frozen=True)
class Matrix:
    rows: tuple[tuple[Expr, ...], ...]


@dataclass(frozen=True)
class Tuple:
    """``(a, b, c)``; with a weight, the inner product of two."""

    items: tuple[Expr, ...]
    weight: Expr | None = None


@dataclass(frozen=True)
class Rest:
    """What an equation leaves unsaid: ``cc`` (complex conjugate), ``nst`` (non-secular terms), ``dots``."""

    kind: str


@dataclass(frozen=True)
class Relation:
    """``left op right`` with ``=``, ``equiv``, ``simeq`` or ``to``."""

    op: str
    left: Expr
    right: Expr


Expr = (
    Num | Sym | Sum | Neg | Prod | Dot | Quot | Power | Prime | Conj | Dagger | Abs | Func | Diff | Int
    | Series | Apply | At | Matrix | Tuple | Rest
)  # fmt: skip
Node = Expr | Relation


@dataclass(frozen=True)
class Equation:
    """One printed equation.

    Attributes:
        label: its name in the ledger, ``eq:follower.2``.
        line: the line on which its display begins.
        latex: its text as printed (blanks and layout removed).
        body: the relation, or, for a display that relates nothing, the tuple of quantities it lists.
        place: where it holds when it says so (``at u = 1``), else None.
        said: where it holds according to the sentence that introduces its display, else None.
    """

    label: str
    line: int
    latex: str
    body: Relation | Tuple
    place: Relation | None = None
    said: Relation | None = None


def children(node: Node) -> Iterator[Node]:
    """The nodes directly below, in printed order."""
    for f in fields(node):
        value = getattr(node, f.name)
        if hasattr(value, "__dataclass_fields__"):
            yield value
        elif isinstance(value, tuple):
            for item in value:
                if isinstance(item, tuple):
                    yield from item
                elif hasattr(item, "__dataclass_fields__"):
                    yield item


def walk(node: Node) -> Iterator[Node]:
    """The node and all nodes below it."""
    yield node
    for child in children(node):
        yield from walk(child)


def rebuild(node: Node, change: Callable[[Node], Node]) -> Node:
    """The same node with ``change`` applied to each direct child."""

    def new(value: object) -> object:
        if isinstance(value, tuple):
            return tuple(new(v) for v in value)
        return change(value) if hasattr(value, "__dataclass_fields__") else value  # type: ignore[arg-type]

    return type(node)(**{f.name: new(getattr(node, f.name)) for f in fields(node)})  # type: ignore[arg-type]


def _subscript(sub: str) -> str:
    if not sub:
        return ""
    return f"_{sub}" if len(sub) == 1 or (sub[0] == "\\" and sub[1:].isalpha()) else f"_{{{sub}}}"
