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

from derivation.paper.reasons import UndecidedError

Kind = Literal[
    "constant", "field", "shape", "exact", "amplitude", "operator", "exp", "sqrt", "integral", "inverse"
]


class Atom:
    """A variable; two with the same description are one object, so that they compare fast.

    ``constant``: parameters, u and t; complex ones have a ``bar``. ``field``: x, y, theta of an order, with
    its derivatives. ``shape``: a function of u in the ansatz. ``exact``: a quantity before expansion.
    ``amplitude``: A(T). ``operator``: a derivative without operand. The rest hold a polynomial, ``arg``.
    ``place``: 0 or 1 for the value there, None at a general u. The square root that is an absolute value
    has the name "abs".
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
COMPLEX = {"alpha", "beta", "lambda", "lambda_F", "lambda_FF", "lambda_FFF"}  # constants that are not real
#: Constants that are positive in every rod.
POSITIVE = {"k1", "k2", "k3", "gamma1", "gamma2", "gamma3", "L", "epsilon", "R", "R_star"}
#: Products of two terms that are still multiplied out.
MOST_PRODUCTS = 200_000
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
        if len(self.terms) * len(right) > MOST_PRODUCTS:
            raise UndecidedError(
                f"a product of {len(self.terms)} and {len(right)} terms is not multiplied out"
            )
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

    def map(self, image: Callable[[Atom], Poly | None], *, integrands: bool = True) -> Poly:
        """Atoms replaced by polynomials, simultaneously; None keeps an atom. Arguments are mapped first.

        ``integrands``: whether those under an integral are mapped too.
        """
        images: dict[Atom, Poly] = {}
        for a in {a for m in self.terms for a, _ in m}:
            value = _image(a, image, integrands)
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
            return atom(a.replace(place=place)) if _is_function(a) else None

        return self.map(value, integrands=False)

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


def _image(a: Atom, image: Callable[[Atom], Poly | None], integrands: bool) -> Poly | None:
    """What an atom is mapped to, its argument first; None when nothing changes."""
    if not isinstance(a.arg, Poly) or (a.kind == "integral" and not integrands):
        return image(a)
    arg = a.arg.map(image, integrands=integrands)
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
    generic = a.kind == "exact" and a.name.startswith("any")  # stands for a complex quantity too
    if generic or a.kind in ("shape", "amplitude") or (a.kind == "constant" and a.name in COMPLEX):
        return atom(a.replace(bar=not a.bar))
    if a.kind == "sqrt":
        if a.name == "abs" or is_positive(a.arg):
            return atom(a)
        raise UndecidedError("the conjugate of a root whose argument is not known to be positive")
    if isinstance(a.arg, Poly):
        return _rebuilt(a.replace(arg=_conjugated_coefficients(a.arg)))
    return None


def is_positive(p: Poly) -> bool:
    """A positive number times positive constants and products of a letter with its conjugate."""
    if len(p.terms) != 1:
        return False
    ((m, c),) = p.terms.items()

    def paired(a: Atom, e: int) -> bool:
        if a.kind == "constant" and a.name in POSITIVE:
            return True
        barred = _bar(a)
        if barred is None or barred == atom(a):
            return e % 2 == 0 or a.kind == "exp"
        return all((b, e) in m for n in barred.terms for b, _ in n)

    return bool(not c.y and c.x > 0) and all(paired(a, e) for a, e in m)


def _conjugated_coefficients(p: Poly) -> Poly:
    """The atoms of an argument are conjugated by map already; its coefficients are not."""
    return Poly({m: QQ_I(c.x, -c.y) for m, c in p.terms.items()})


def _is_function(a: Atom) -> bool:
    """A letter that depends on u."""
    return a.kind in ("field", "shape", "exact") and a.place is None


def depends_on_u(a: Atom) -> bool:
    """Whether an atom or something in its argument depends on u; an integral over the rod does not."""
    if isinstance(a.arg, Poly):
        return a.kind != "integral" and any(depends_on_u(b) for m in a.arg.terms for b, _ in m)
    return a == U or _is_function(a)


def _rate(a: Atom, variable: str) -> Poly | None:
    """The derivative of an atom; None when it is constant.

    Raises:
        UndecidedError: for what has no derivative here, such as an operator.
    """
    if a.kind == "operator":
        raise UndecidedError("the derivative of an operator without its operand")
    if isinstance(a.arg, Poly):
        return _rate_of_argument(a, variable)
    if a.kind == "constant":
        return _rate_of_constant(a, variable)
    if a.kind == "amplitude" and variable in ("T", "t"):
        return atom(a.replace(slow=a.slow + 1)) * _slow(variable)
    if a.kind == "field" and variable in ("tau", "t"):
        return atom(a.replace(tau=a.tau + 1))
    if a.kind == "field" and variable == "T":
        return atom(a.replace(slow=a.slow + 1))
    if a.kind == "exact" and variable in ("tau", "T"):
        raise UndecidedError("a derivative along one of the two times, of a quantity that is not expanded")
    if a.kind == "exact" and a.name in ("cos", "sin"):
        other = "sin" if a.name == "cos" else "cos"
        theta = _rate(Atom("exact", "theta", place=a.place), variable)
        return None if theta is None else theta * atom(a.replace(name=other)) * (-1 if other == "sin" else 1)
    if a.kind == "exact" and variable == "t":
        return atom(a.replace(tau=a.tau + 1))
    if variable == "u" and _is_function(a):
        return atom(a.replace(u=a.u + 1))
    return None


def _slow(variable: str) -> Poly:
    """dT/dT or dT/dt, T = epsilon^2 t."""
    return poly(1) if variable == "T" else constant("epsilon") ** 2


def _rate_of_constant(a: Atom, variable: str) -> Poly | None:
    if a.name == variable or (a.name == "t" and variable == "tau"):
        return poly(1)
    if variable not in ("T", "t"):
        return None
    if a.name == "T":
        return _slow(variable)
    if a.name.endswith("_T"):
        raise UndecidedError("a second derivative along the slow time")
    return constant(f"{a.name}_T") * _slow(variable) if a.name in ("R", "phase") else None


def _rate_of_argument(a: Atom, variable: str) -> Poly | None:
    """d e^p = p' e^p, d sqrt p = p' / (2 sqrt p), d 1/p = -p' / p^2, d int p du = int p' du."""
    rate: Poly = a.arg.derive(variable)
    if not rate or (a.kind == "integral" and variable == "u"):
        return None
    if a.kind == "exp":
        return atom(a) * rate
    if a.kind == "sqrt":
        return rate * rational(1, 2) * atom(a).inverse()
    return -rate * atom(a) ** 2 if a.kind == "inverse" else atom(a.replace(arg=rate))
