"""Laurent polynomials over the Gaussian rationals in atoms that are made when they are met.

A paper's equation may hold any letter, at any order, at an end of the rod, in an exponential or under an
integral; the rings of :mod:`derivation.jets` have a fixed list of variables. Here a variable is an
:class:`Atom`, a monomial a set of atoms with their (possibly negative) powers, and derived objects are
carried over by :mod:`derivation.paper.carry`. As there, equality is that the difference is zero.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from typing import Any, ClassVar, Literal, Union

from sympy import QQ_I

Kind = Literal[
    "constant", "field", "shape", "exact", "amplitude", "operator", "exp", "sqrt", "integral", "inverse"
]


class Atom:
    """A variable; two with the same description are one object, so that they compare fast.

    ``constant``: parameters, u and t; complex ones have a ``bar``. ``field``: x, y, theta of an order, with
    its derivatives. ``shape``: a function of u in the ansatz. ``exact``: a quantity before expansion.
    ``amplitude``: A(T). ``operator``: a derivative without operand. The rest hold a polynomial, ``arg``.
    ``place``: 0 or 1 for the value there, None at a general u.
    """

    __slots__ = ("arg", "bar", "kind", "name", "order", "place", "slow", "tau", "u")
    _made: ClassVar[dict[tuple[Any, ...], Atom]] = {}
    kind: Kind
    name: str
    order: int
    u: int
    tau: int
    slow: int
    bar: bool
    place: int | None
    arg: Any

    def __new__(
        cls, kind: Kind, name: str = "", order: int = 0, u: int = 0, tau: int = 0, slow: int = 0,
        bar: bool = False, place: int | None = None, arg: Any = None,
    ) -> Atom:  # fmt: skip
        key = (kind, name, order, u, tau, slow, bar, place, arg)
        made = cls._made.get(key)
        if made is None:
            made = object.__new__(cls)
            for slot, value in zip(_FIELDS, key, strict=True):
                setattr(made, slot, value)
            cls._made[key] = made
        return made

    def replace(self, **changes: Any) -> Atom:
        """The same with some entries changed."""
        return Atom(**{**{f: getattr(self, f) for f in _FIELDS}, **changes})

    def __repr__(self) -> str:
        return "/".join(str(getattr(self, f)) for f in _FIELDS)


_FIELDS = ("kind", "name", "order", "u", "tau", "slow", "bar", "place", "arg")
Monomial = frozenset[tuple[Atom, int]]
ONE: Monomial = frozenset()
COMPLEX = {"alpha", "beta", "lambda"}  # constants that are not real
Number = Union[int, "Poly"]


class Poly:
    """A finite sum of Gaussian rationals times monomials; zero has no terms. Never changed once made."""

    __slots__ = ("_hash", "terms")

    def __init__(self, terms: dict[Monomial, Any]) -> None:
        self.terms = terms
        self._hash: int | None = None

    @staticmethod
    def of(items: Iterable[tuple[Monomial, Any]]) -> Poly:
        total: dict[Monomial, Any] = {}
        for m, c in items:
            total[m] = total[m] + c if m in total else c
        return Poly({m: c for m, c in total.items() if c})

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Poly) and self.terms == other.terms

    def __hash__(self) -> int:
        if self._hash is None:
            self._hash = hash(frozenset(self.terms))
        return self._hash

    def __repr__(self) -> str:
        return " + ".join(sorted(f"{c}*{sorted(m, key=repr)}" for m, c in self.terms.items()))

    def __bool__(self) -> bool:
        return bool(self.terms)

    def __add__(self, other: Number) -> Poly:
        total = dict(self.terms)
        for m, c in poly(other).terms.items():
            total[m] = total[m] + c if m in total else c
        return Poly({m: c for m, c in total.items() if c})

    __radd__ = __add__

    def __neg__(self) -> Poly:
        return Poly({m: -c for m, c in self.terms.items()})

    def __sub__(self, other: Number) -> Poly:
        return self + (-poly(other))

    def __rsub__(self, other: Number) -> Poly:
        return poly(other) + (-self)

    def __mul__(self, other: Number) -> Poly:
        right = poly(other).terms.items()
        return Poly.of((_times(m, n), c * d) for m, c in self.terms.items() for n, d in right)

    __rmul__ = __mul__

    def __pow__(self, n: int) -> Poly:
        if n < 0:
            return self.inverse() ** -n
        result = poly(1)
        for _ in range(n):
            result = result * self
        return result

    def inverse(self) -> Poly:
        """1/self; of a sum it is an atom of its own, which :func:`cleared` multiplies away.

        Raises:
            ZeroDivisionError: if self is zero.
        """
        if not self:
            raise ZeroDivisionError("division by zero")
        if len(self.terms) > 1:
            return atom(Atom("inverse", arg=self))
        ((m, c),) = self.terms.items()
        return Poly.of([(normal((a, -e) for a, e in m), QQ_I.one / c)])

    @property
    def is_atom(self) -> bool:
        """A single letter, with nothing before it."""
        return len(self.terms) == 1 and all(c == 1 and len(m) == 1 for m, c in self.terms.items())

    @property
    def atoms(self) -> set[Atom]:
        """The atoms that occur, those inside exponentials and integrals included."""
        found = {a for m in self.terms for a, _ in m}
        return found.union(*(a.arg.atoms for a in found if isinstance(a.arg, Poly)))

    def map(self, image: Callable[[Atom], Poly | None]) -> Poly:
        """Atoms replaced by polynomials, simultaneously; None keeps an atom. Arguments are mapped first."""
        images: dict[Atom, Poly] = {}
        for a in {a for m in self.terms for a, _ in m}:
            value = _image(a, image)
            if value is not None:
                images[a] = value
        return self.replaced(images)

    def replaced(self, images: Mapping[Atom, Poly]) -> Poly:
        """The atoms of a table replaced by polynomials, those in arguments not."""
        if not images:
            return self
        total: dict[Monomial, Any] = {}
        for m, c in self.terms.items():
            changed = [(a, e) for a, e in m if a in images]
            term = Poly({m.difference(changed): c})
            for a, e in changed:
                term = term * images[a] ** e
            for n, d in term.terms.items():
                total[n] = total[n] + d if n in total else d
        return Poly({m: c for m, c in total.items() if c})

    def rewrite(self, image: Callable[[Atom], Poly | None]) -> Poly:
        """:meth:`map` until nothing changes.

        Raises:
            RuntimeError: the rules go round in a circle.
        """
        p = self
        for _ in range(30):
            q = p.map(image)
            if q is p:
                return p
            p = q
        raise RuntimeError("circular rewriting rules")

    def conjugate(self) -> Poly:
        return _conjugated_coefficients(self).map(_bar)

    def derive(self, variable: str) -> Poly:
        """The derivative along u, tau, T or t, or with respect to a constant of that name."""
        total: list[tuple[Monomial, Any]] = []
        for m, c in self.terms.items():
            for a, e in m:
                rate = _rate(a, variable)
                if rate:
                    rest = _times(m, frozenset([(a, -1)]))
                    total.extend((Poly({rest: c * e}) * rate).terms.items())
        return Poly.of(total)

    def at(self, place: int) -> Poly:
        """The value at u = 0 or 1."""

        def value(a: Atom) -> Poly | None:
            if a == U:
                return poly(place)
            return atom(a.replace(place=place)) if _depends_on_u(a) else None

        return self.map(value)

    def keep(self, wanted: Callable[[Monomial], bool]) -> Poly:
        """The terms whose monomial is wanted."""
        return Poly({m: c for m, c in self.terms.items() if wanted(m)})

    def degree(self, a: Atom) -> int:
        return max((dict(m).get(a, 0) for m in self.terms), default=0)


def poly(value: Number) -> Poly:
    """A rational number (or a polynomial, unchanged) as a polynomial."""
    if isinstance(value, Poly):
        return value
    return _INTEGERS[value] if value in _INTEGERS else rational(value, 1)


def rational(numerator: int, denominator: int) -> Poly:
    c = QQ_I(numerator, 0) / QQ_I(denominator, 0)
    return Poly({ONE: c} if c else {})


_INTEGERS = {n: rational(n, 1) for n in range(-3, 4)}


def atom(a: Atom) -> Poly:
    return Poly({frozenset([(a, 1)]): QQ_I.one})


def constant(name: str) -> Poly:
    return atom(Atom("constant", name))


def exp(p: Poly) -> Poly:
    return atom(Atom("exp", arg=p)) if p else poly(1)


I = Poly({ONE: QQ_I(0, 1)})  # noqa: E741
U, T_ATOM = Atom("constant", "u"), Atom("constant", "t")


def cleared(p: Poly) -> Poly:
    """p times the denominators that are sums."""
    for _ in range(20):
        inverse = next((a for m in p.terms for a, _ in m if a.kind == "inverse"), None)
        if inverse is None:
            return p
        most = p.degree(inverse)
        p = Poly.of(
            pair
            for m, c in p.terms.items()
            for e in [dict(m).get(inverse, 0)]
            for pair in (Poly({m - {(inverse, e)}: c}) * inverse.arg ** (most - e)).terms.items()
        )
    raise RuntimeError("too many denominators")


def harmonic(m: Monomial) -> int:
    """The multiple of omega_c t in the exponential of a monomial (0 without one)."""
    for a, _ in m:
        if a.kind == "exp":
            rate = a.arg.derive("t")
            (n,) = [
                c.y for k, c in rate.terms.items() if k == frozenset([(Atom("constant", "omega"), 1)])
            ] or [0]
            return int(n) if n == int(n) else 99
    return 0


def _times(m: Monomial, n: Monomial) -> Monomial:
    if not n:
        return m
    powers = dict(m)
    for a, e in n:
        powers[a] = powers.get(a, 0) + e
    return normal(powers.items())


def normal(items: Iterable[tuple[Atom, int]]) -> Monomial:
    """Zero powers dropped, exponentials joined into one."""
    kept = [(a, e) for a, e in items if e]
    exps = [(a, e) for a, e in kept if a.kind == "exp"]
    if exps and (len(exps) > 1 or exps[0][1] != 1):
        exponent = sum((a.arg * e for a, e in exps), poly(0))
        kept = [x for x in kept if x[0].kind != "exp"]
        if exponent:
            kept.append((Atom("exp", arg=exponent), 1))
    return frozenset(kept)


def _image(a: Atom, image: Callable[[Atom], Poly | None]) -> Poly | None:
    """What an atom is mapped to, its argument first; None when nothing changes."""
    if not isinstance(a.arg, Poly):
        return image(a)
    arg = a.arg.map(image)
    new = a if arg is a.arg else a.replace(arg=arg)
    value = image(new)
    return _rebuilt(new) if value is None and new is not a else value


def _rebuilt(a: Atom) -> Poly:
    """An atom whose argument may have changed."""
    if a.kind == "exp":
        return exp(a.arg)
    if a.kind == "inverse":
        inverse: Poly = a.arg.inverse()
        return inverse
    return atom(a) if a.kind != "integral" or a.arg else poly(0)


def _bar(a: Atom) -> Poly | None:
    if a.kind in ("shape", "amplitude") or (a.kind == "constant" and a.name in COMPLEX):
        return atom(a.replace(bar=not a.bar))
    if isinstance(a.arg, Poly):
        return _rebuilt(a.replace(arg=_conjugated_coefficients(a.arg)))
    return None


def _conjugated_coefficients(p: Poly) -> Poly:
    """The atoms of an argument are conjugated by map already; its coefficients are not."""
    return Poly({m: QQ_I(c.x, -c.y) for m, c in p.terms.items()})


def _depends_on_u(a: Atom) -> bool:
    return a.kind in ("field", "shape", "exact") and a.place is None


def _rate(a: Atom, variable: str) -> Poly | None:
    """The derivative of an atom; None when it is constant."""
    if a.kind == "constant":
        if a.name == variable or (a.name == "t" and variable == "tau"):
            return poly(1)
        return constant(f"{a.name}_T") if variable == "T" and a.name in ("R", "phase") else None
    if a.kind == "exp":
        rate: Poly = a.arg.derive(variable)
        return atom(a) * rate
    if a.kind == "amplitude":
        return atom(a.replace(slow=a.slow + 1)) if variable == "T" else None
    if a.kind == "field" and variable in ("tau", "t"):
        return atom(a.replace(tau=a.tau + 1))
    if a.kind == "field" and variable == "T":
        return atom(a.replace(slow=a.slow + 1))
    if a.kind == "exact" and a.name in ("cos", "sin"):
        other = "sin" if a.name == "cos" else "cos"
        theta = _rate(Atom("exact", "theta", place=a.place), variable)
        return None if theta is None else theta * atom(a.replace(name=other)) * (-1 if other == "sin" else 1)
    if a.kind == "exact" and variable == "t":
        return atom(a.replace(tau=a.tau + 1))
    if variable == "u" and _depends_on_u(a):
        return atom(a.replace(u=a.u + 1))
    return None
