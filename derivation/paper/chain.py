"""What an error in a printed equation would do: the chain of formulas to alpha and beta with it put in.

The chain is what the numbers are computed from: forcings and tip values of X0 and X2, the tensions P0 and P2,
g1 ... g4 and the integrals. A printed equation that does not hold replaces its link.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import Any

from sympy.polys.rings import PolyElement

from derivation.adjoint import adjoint_problem
from derivation.corrections import second_order
from derivation.errors import ModelError
from derivation.harmonics import first_order
from derivation.hierarchy import build_hierarchy
from derivation.paper.algebra import Atom, Poly, atom, constant, depends_on_u, harmonic, poly
from derivation.paper.byparts import ADJOINT
from derivation.paper.carry import from_ring
from derivation.paper.kinds import is_identity, order_of
from derivation.paper.lower import Lowering
from derivation.paper.meanings import STRAINS, VELOCITIES
from derivation.paper.notation import Notation
from derivation.paper.reasons import UndecidedError, UnfitError
from derivation.paper.reduction import reduced
from derivation.paper.rows import Row
from derivation.paper.syntax import Apply, Prime, Relation, Sym, walk
from derivation.paper.theory import Theory
from derivation.pipeline import Derivation
from derivation.resonance import third_order
from derivation.solvability import solvability

AMPLITUDE = frozenset({"R", "R_star", "sigma", "A_tip", "lambda", "phase", "delta", "omega"})
CUBIC, DETUNING = "cubic", "detuning"


@dataclass(frozen=True)
class Chain:
    """The links. Polynomials in shapes of u, the constants and each other (P0, P2 and H are letters).

    Attributes:
        drag, forcing, slope: of k1 X'' = drag X + forcing, X'(1) = slope, for "X0" and "X2".
        tension: "P0", "P2".
        g: "g1" ... "g4".
        norm: integrand of the denominator.
        boundary: tip terms added to the numerators.
        whole: "alpha", "beta" where they are replaced as a whole, as functions of integrals.
    """

    drag: Mapping[str, Poly]
    forcing: Mapping[str, Poly]
    slope: Mapping[str, Poly]
    tension: Mapping[str, Poly]
    g: Mapping[str, Poly]
    norm: Poly
    boundary: Mapping[str, Poly] = field(default_factory=dict)
    whole: Mapping[str, Poly] = field(default_factory=dict)


def chain_of(d: Derivation) -> Chain:
    """The chain as derived.

    Raises:
        ArithmeticError: if the rod has no transformed variables of order 3.
    """
    if d.third.transformed is None:
        raise ArithmeticError("no transformed variables of order 3")
    corrections = {"0": d.second.mean, "2": d.second.harmonic}
    return Chain(
        {f"X{n}": from_ring(c.drag) for n, c in corrections.items()},
        {f"X{n}": from_ring(c.forcing) for n, c in corrections.items()},
        {f"X{n}": from_ring(c.tip_slope).at(1) for n, c in corrections.items()},
        {f"P{n}": from_ring(c.tension) for n, c in corrections.items()},
        {f"g{k}": from_ring(g) for k, g in enumerate(d.third.transformed.g, 1)},
        from_ring(d.landau.norm.integrand),
    )


def changed(row: Row, notation: Notation, theory: Theory) -> Chain | str:
    """The chain with the printed equation in it, or in words why there is none."""
    low = Lowering(row.equation, notation, theory)
    body = row.equation.body
    if not isinstance(body, Relation) or not row.difference:
        return "the equation has no meaning to compute with"
    if low.names & AMPLITUDE and not low.names & {"g1", "g2", "g3", "g4"}:
        return "alpha and beta do not depend on it; what is predicted from them does"
    try:
        found = _other_kinematics(low, body, theory) if is_identity(low) else _replaced(low, body, theory)
    except (UndecidedError, UnfitError):
        return "the equation has no meaning to compute with"
    except ModelError as breaks:
        return f"the derivation breaks down with it: {breaks}"
    except (ArithmeticError, KeyError):
        return "the derivation breaks down with it"
    if isinstance(found, Chain) and not _is_computable(found, theory):
        return "no theory follows with it: alpha and beta would hold a quantity that nothing determines"
    return found or "it changes the linear problem or the rod itself, and so the thresholds"


def _is_computable(chain: Chain, theory: Theory) -> bool:
    """Whether each link holds parameters of the rod, u, and shapes that are known before it."""
    parameters = {*theory.d.law.parameters, "omega", "nu", "mu", "u"}
    first = parameters | {"Y", "Theta", "H"}
    second = first | {"X0", "X2"}
    third = second | {"P0", "P2", *ADJOINT}
    numbers = ((chain.drag, first), (chain.slope, first), (chain.boundary, third), (chain.whole, third))
    functions = ((chain.forcing, first), (chain.tension, second), (chain.g, third))

    def known(p: Poly, names: set[str]) -> bool:
        inner, outer = ("constant", "shape"), ("sqrt", "inverse", "integral")
        return all(a.kind in outer or (a.kind in inner and a.name in names) for a in p.atoms)

    return all(
        known(p, names) and not any(depends_on_u(a) for m in p.terms for a, _ in m)
        for table, names in numbers
        for p in table.values()
    ) and all(known(p, names) for table, names in functions for p in table.values())


def _replaced(low: Lowering, body: Relation, theory: Theory) -> Chain | None:
    chain = chain_of(theory.d)
    quantity = _head(low, body)
    if quantity in chain.g:
        return replace(chain, g={**chain.g, quantity: low.scalar(body.right)})
    if quantity in chain.tension:
        return replace(chain, tension={**chain.tension, quantity: low.scalar(body.right)})
    if quantity in ("alpha", "beta") and low.names & {"g1", "g2"}:
        return replace(chain, whole={quantity: low.scalar(body.right)})
    rest = _remainder(low)
    if low.names & {"X0", "X2"} and order_of(low) == 0:
        return _correction(chain, rest, low.place)
    if order_of(low) == 2:
        return _second(chain, rest, quantity)
    if order_of(low) == 3:
        return _third(chain, rest, low, body, theory)
    return None


def _remainder(low: Lowering) -> Poly:
    """Left minus right on the derived solutions, everything unsaid dropped."""
    (p, *more) = low.differences()
    if more:
        raise UndecidedError("a system of equations")
    return low.theory.insert_waves(reduced(low, p))


def _head(low: Lowering, body: Relation) -> str:
    head = body.left.fn if isinstance(body.left, Apply) else body.left
    while isinstance(head, Prime):
        head = head.arg
    return (low.notation.quantity(head.name) if isinstance(head, Sym) else None) or ""


def _correction(chain: Chain, rest: Poly, place: int | None) -> Chain | None:
    """rest = k1 X'' - ... of one of the two problems, or X'(1) - ... of its condition."""
    names = {a.name for a in rest.atoms if a.kind == "shape" and a.name in ("X0", "X2")}
    if len(names) > 1:
        return None
    return None if place == 0 else _shifted(chain, rest, names, place)


def _shifted(chain: Chain, rest: Poly, names: set[str], place: int | None) -> Chain | None:
    if names:
        return None  # the left side itself is wrong
    double = any(a.name in ("Theta", "H", "Y") and not a.bar for a in rest.atoms) and not any(
        a.bar for a in rest.atoms
    )
    name = "X2" if double else "X0"
    where = "slope" if place == 1 or any(a.place == 1 for a in rest.atoms) else "forcing"
    table = {**getattr(chain, where), name: getattr(chain, where)[name] - rest}
    return replace(chain, slope=table) if where == "slope" else replace(chain, forcing=table)


def _second(chain: Chain, rest: Poly, quantity: str) -> Chain | None:
    """An error in f1, b1 or a law of order 2, by its harmonics: printed = derived - rest."""
    if any(a.kind == "field" for a in rest.atoms) or quantity in ("x", "F1"):
        return None
    sign = 1 if quantity == "f1" else -1
    where = "slope" if any(a.place == 1 for a in rest.atoms) else "forcing"
    a, a_bar = atom(Atom("amplitude", "A")), atom(Atom("amplitude", "A", bar=True))
    table = dict(getattr(chain, where))
    for name, m, product in (("X0", 0, a * a_bar * 2), ("X2", 2, a**2)):
        part = _without_time(rest.keep(lambda k, m=m: harmonic(k) == m and _has_amplitude(k)))  # type: ignore[misc]
        table[name] = table[name] + part * product.inverse() * (sign if where == "forcing" else -1)
    return replace(chain, slope=table) if where == "slope" else replace(chain, forcing=table)


def _third(chain: Chain, rest: Poly, low: Lowering, body: Relation, theory: Theory) -> Chain | None:
    """An error in a law or a condition of order 3, by its resonant part."""
    if any(a.kind == "field" for a in rest.atoms):
        return None
    names = {low.notation.quantity(s.name) for s in walk(body.left) if isinstance(s, Sym)}
    angular = bool(names & {"Omega", "theta_hat", "theta", "f3", "M"}) and not names & {"y", "F2"}
    given = bool(names & {"f2", "f3"})
    a, a_bar = atom(Atom("amplitude", "A")), atom(Atom("amplitude", "A", bar=True))
    resonant = _without_time(rest.keep(lambda k: harmonic(k) == 1))
    parts = {
        CUBIC: _coefficient(resonant, a**2 * a_bar),
        DETUNING: _coefficient(resonant, constant("Delta") * a),
    }
    if low.place == 1:
        psi = atom(Atom("shape", "Psi_Theta" if angular else "Psi_Y", bar=True, place=1))
        weight = psi if angular else constant("k2") * psi
        return replace(chain, boundary={k: -weight * p for k, p in parts.items()})
    g = dict(chain.g)
    for name, part in zip(("g3", "g4") if angular else ("g1", "g2"), parts.values(), strict=True):
        g[name] = g[name] - part
    return replace(chain, g=g) if given or low.place is None else None


def _coefficient(p: Poly, product: Poly) -> Poly:
    """The coefficient of a product of amplitudes (and of the detuning)."""
    (wanted,) = product.terms
    kept = p.keep(
        lambda m: frozenset((a, e) for a, e in m if a.kind == "amplitude" or a.name == "Delta") == wanted
    )
    return kept * product.inverse()


def _without_time(p: Poly) -> Poly:
    return p.map(lambda a: poly(1) if a.kind == "exp" else None)


def _has_amplitude(m: frozenset[tuple[Atom, int]]) -> bool:
    return any(a.kind == "amplitude" for a, _ in m)


def _other_kinematics(low: Lowering, body: Relation, theory: Theory) -> Chain | str:
    """Derive everything again with the printed expansion in the place of the derived one."""
    d, n = theory.d, order_of(low)
    head = body.left
    assert isinstance(head, Sym)
    if n == 1:
        return "it changes the linear problem, and so the thresholds"
    quantity = low.notation.quantity(head.name)
    printed = _to_ring(theory.canonical(low.scalar(body.right), keep=frozenset({"nu", "mu"})), d)
    series: list[list[Any]] = [list(d.kinematics.strains), list(d.kinematics.velocities)]
    for names, table in zip((STRAINS, VELOCITIES), series, strict=True):
        if quantity in names:
            k = names.index(quantity)
            table[k] = (*table[k][: int(head.order)], printed, *table[k][int(head.order) + 1 :])
    (h1, h2, bend), (v1, v2, spin) = series
    kinematics = replace(d.kinematics, strains=(h1, h2, bend), velocities=(v1, v2, spin))
    hierarchy = build_hierarchy(d.model, d.law, kinematics)
    modes = first_order(hierarchy)
    second = second_order(hierarchy, modes)
    third = third_order(hierarchy, second)
    landau = solvability(hierarchy, third, adjoint_problem(hierarchy, second.modes))
    return chain_of(
        replace(d, kinematics=kinematics, hierarchy=hierarchy, second=second, third=third, landau=landau)
    )


def _to_ring(p: Poly, d: Derivation) -> PolyElement:
    """An expansion, polynomial in jets, as an element of the derivation's ring of jets."""
    ring = d.kinematics.ring
    names = {_one(from_ring(g)): g for g in ring.ring.gens if not str(g).endswith("_inv")}
    total = ring.zero
    for m, c in p.terms.items():
        term = ring.ring.ground_new(c)
        for a, e in m:
            if a not in names:
                raise UndecidedError("an expansion in other letters")
            term = term * (names[a] ** e if e > 0 else ring[f"{a.name}_inv"] ** -e)
        total += term
    return total


def _one(p: Poly) -> Atom:
    ((a, _),) = next(iter(p.terms))
    return a
