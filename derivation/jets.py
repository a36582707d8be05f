"""The algebra: differential polynomials over the Gaussian rationals.

Everything in the theory is a polynomial once each derivative of a field is a variable of its own (a
*jet*). A :class:`JetRing` is such a polynomial ring together with what makes it differential: derivations
that shift jets, a conjugation that swaps variables, and the rewriting of products that are known
(``k1 * k1_inv = 1``). Equality is then decidable: two expressions are equal iff their difference reduces
to zero. Nothing here simplifies, samples or guesses.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field

from sympy import QQ_I, Expr, Poly
from sympy.polys.rings import PolyElement, PolyRing
from sympy.polys.rings import ring as make_ring

from derivation.symbols import symbol

Images = Mapping[PolyElement, PolyElement]


@dataclass(frozen=True, eq=False)
class JetRing:
    """A polynomial ring with derivations, a conjugation and known products.

    ``derivations[name]`` maps a generator to its derivative; generators that are absent are constants.
    ``conjugates`` maps a generator to its conjugate; generators that are absent are real.
    ``products`` lists rewrites ``(monomial, value)``; none may produce what an earlier one rewrites.
    """

    ring: PolyRing
    derivations: Mapping[str, Images] = field(default_factory=dict)
    conjugates: Images = field(default_factory=dict)
    products: tuple[tuple[PolyElement, PolyElement], ...] = ()

    def __getitem__(self, name: str) -> PolyElement:
        """The generator of that name.

        Raises:
            KeyError: if the ring has no such generator.
        """
        return self._by_name[name]

    def __contains__(self, name: str) -> bool:
        return name in self._by_name

    @property
    def _by_name(self) -> dict[str, PolyElement]:
        names = self.__dict__.get("_names")
        if names is None:
            names = dict(zip(self.names, self.ring.gens, strict=True))
            object.__setattr__(self, "_names", names)
        return names

    @property
    def names(self) -> tuple[str, ...]:
        """The generators' names, in the ring's order (printing a generator is slow)."""
        return tuple(s.name for s in self.ring.symbols)

    @property
    def zero(self) -> PolyElement:
        return self.ring.zero

    @property
    def one(self) -> PolyElement:
        return self.ring.one

    @property
    def i(self) -> PolyElement:
        """The imaginary unit as a constant of the ring."""
        return self.ring.ground_new(QQ_I(0, 1))

    def derive(self, p: PolyElement, name: str) -> PolyElement:
        """The derivation ``name`` applied to ``p``: sum of dp/dg times the image of g.

        Raises:
            KeyError: if a jet of too high an order would be needed (its image is None).
        """
        images = self.derivations[name]
        total = self.zero
        for g in self.generators_of(p):
            image = images.get(g)
            if image is None:
                if g in images:
                    raise KeyError(f"the ring holds no {name}-derivative of {g}; raise its jet order")
                continue
            total += p.diff(g) * image
        return total

    def conjugate(self, p: PolyElement) -> PolyElement:
        """Complex conjugate: coefficients conjugated, conjugate variables swapped."""
        place = self._conjugate_places()
        out: dict[tuple[int, ...], object] = {}
        for monom, coeff in p.terms():
            moved = [0] * len(monom)
            for k, e in enumerate(monom):
                if e:
                    moved[place[k]] = e
            out[tuple(moved)] = QQ_I(coeff.x, -coeff.y)
        return self.ring.from_dict(out)

    def _conjugate_places(self) -> list[int]:
        places = self.__dict__.get("_places")
        if places is None:
            index = {g: k for k, g in enumerate(self.ring.gens)}
            places = [index[self.conjugates.get(g, g)] for g in self.ring.gens]
            object.__setattr__(self, "_places", places)
        return places

    def real(self, p: PolyElement) -> PolyElement:
        """(p + p*)/2."""
        return (p + self.conjugate(p)) / 2

    def reduce(self, p: PolyElement) -> PolyElement:
        """Rewrite known products until none is left (``k1 * k1_inv`` becomes 1)."""
        for monomial, value in self.products:
            p = _rewrite(p, monomial, value)
        return p

    def generators_of(self, p: PolyElement) -> list[PolyElement]:
        """The generators that occur in ``p``, in the ring's order."""
        degrees = [0] * len(self.ring.gens)
        for monom in p.monoms():
            degrees = [a or b for a, b in zip(degrees, monom, strict=True)]
        return [g for g, d in zip(self.ring.gens, degrees, strict=True) if d]

    def names_of(self, p: PolyElement) -> list[str]:
        """Names of the generators that occur in ``p``."""
        return [s.name for k, s in enumerate(p.ring.symbols) if any(m[k] for m in p.monoms())]

    def apply(self, p: PolyElement, images: Images) -> PolyElement:
        """Replace generators by polynomials of this ring, simultaneously."""
        return homomorphism(p, images, self)

    def rewrite(self, p: PolyElement, rules: Images) -> PolyElement:
        """Replace generators again and again until none of the rules' keys is left, then reduce.

        Raises:
            RuntimeError: if the rules are circular.
        """
        for _ in range(len(rules) + 2):
            keys = [g for g in self.generators_of(p) if g in rules]
            if not keys:
                return self.reduce(p)
            p = self.reduce(self.apply(p, {g: rules[g] for g in keys}))
        raise RuntimeError(f"circular rewriting rules for {', '.join(map(str, keys))}")

    def coefficient(self, p: PolyElement, monomial: PolyElement, of: Iterable[PolyElement]) -> PolyElement:
        """Coefficient of ``monomial`` in ``p`` seen as a polynomial in the generators ``of``."""
        wanted = monomial.leading_expv()
        index = {g: k for k, g in enumerate(self.ring.gens)}
        places = [index[g] for g in of]
        out: dict[tuple[int, ...], object] = {}
        for monom, coeff in p.terms():
            if all(monom[k] == wanted[k] for k in places):
                rest = list(monom)
                for k in places:
                    rest[k] = 0
                out[tuple(rest)] = coeff
        return self.ring.from_dict(out)

    def parts(self, p: PolyElement, of: Iterable[PolyElement]) -> dict[PolyElement, PolyElement]:
        """Split ``p`` by its monomials in the generators ``of``: monomial -> coefficient."""
        index = {g: k for k, g in enumerate(self.ring.gens)}
        places = [index[g] for g in of]
        split: dict[tuple[int, ...], dict[tuple[int, ...], object]] = {}
        for monom, coeff in p.terms():
            key = [0] * len(monom)
            rest = list(monom)
            for k in places:
                key[k], rest[k] = monom[k], 0
            split.setdefault(tuple(key), {})[tuple(rest)] = coeff
        return {
            self.ring.from_dict({key: QQ_I.one}): self.ring.from_dict(terms) for key, terms in split.items()
        }

    def degree(self, p: PolyElement, of: Iterable[PolyElement]) -> int:
        """Total degree of the (nonzero) polynomial ``p`` in the generators ``of``."""
        index = {g: k for k, g in enumerate(self.ring.gens)}
        places = [index[g] for g in of]
        return max((sum(m[k] for k in places) for m in p.monoms()), default=0)


def jet_ring(
    names: Iterable[str],
    derivations: Mapping[str, Mapping[str, str | None]] | None = None,
    conjugates: Mapping[str, str] | None = None,
    inverses: Mapping[str, str] | None = None,
) -> JetRing:
    """Build a ring from names.

    ``derivations`` gives the image of a generator as a generator's name (None: beyond the highest jet held),
    ``conjugates`` pairs (either direction suffices), ``inverses`` maps ``k1`` to ``k1_inv``.
    """
    names = list(names)
    poly_ring, *gens = make_ring([symbol(n) for n in names], QQ_I)
    by = dict(zip(names, gens, strict=True))
    pairs = dict(conjugates or {})
    pairs.update({b: a for a, b in pairs.items()})
    return JetRing(
        poly_ring,
        {
            d: {by[a]: (None if b is None else by[b]) for a, b in images.items()}
            for d, images in (derivations or {}).items()
        },
        {by[a]: by[b] for a, b in pairs.items()},
        tuple((by[a] * by[b], poly_ring.one) for a, b in (inverses or {}).items()),
    )


def homomorphism(p: PolyElement, images: Images, target: JetRing) -> PolyElement:
    """Map ``p`` into ``target``: generators to ``images``, the others to their namesakes.

    Raises:
        KeyError: if a generator of ``p`` has neither an image nor a namesake in ``target``.
    """
    gens, symbols = p.ring.gens, p.ring.symbols
    powers: dict[tuple[int, int], PolyElement] = {}

    def power(k: int, e: int) -> PolyElement:
        if (k, e) not in powers:
            g = gens[k]
            base = images[g] if g in images else target[symbols[k].name]
            powers[k, e] = base**e
        return powers[k, e]

    total = target.zero
    for monom, coeff in p.terms():
        term = target.ring.ground_new(coeff)
        for k, e in enumerate(monom):
            if e:
                term = term * power(k, e)
        total += term
    return total


def _rewrite(p: PolyElement, monomial: PolyElement, value: PolyElement) -> PolyElement:
    """Replace every occurrence of ``monomial`` as a factor by ``value``."""
    head = monomial.leading_expv()
    places = [(k, e) for k, e in enumerate(head) if e]
    todo, done = p, p.ring.zero
    while todo:
        keep: dict[tuple[int, ...], object] = {}
        again = p.ring.zero
        for monom, coeff in todo.terms():
            times = min(monom[k] // e for k, e in places)
            if not times:
                keep[monom] = coeff
                continue
            rest = list(monom)
            for k, e in places:
                rest[k] -= times * e
            again += p.ring.from_dict({tuple(rest): coeff}) * value**times
        done += p.ring.from_dict(keep)
        todo = again
    return done


def from_expr(expr: Expr, target: JetRing) -> PolyElement:
    """A SymPy polynomial as an element of ``target``.

    Raises:
        ValueError: if ``expr`` is not a polynomial in generators of ``target``.
    """
    missing = sorted(s.name for s in expr.free_symbols if s.name not in target)
    if missing:
        raise ValueError(f"{expr}: no such symbols here: {', '.join(missing)}")
    symbols = sorted(expr.free_symbols, key=str)
    if not symbols:
        return target.ring.ground_new(QQ_I.from_sympy(expr))
    if not expr.is_polynomial(*symbols):
        raise ValueError(f"{expr} is not a polynomial in {', '.join(map(str, symbols))}")
    poly = Poly(expr, *symbols, domain=QQ_I)
    total = target.zero
    for monom, coeff in poly.rep.to_dict().items():
        term = target.ring.ground_new(coeff)
        for s, e in zip(symbols, monom, strict=True):
            term = term * target[s.name] ** e
        total += term
    return total
