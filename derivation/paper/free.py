"""Whether what is left of an equation shows that it does not hold.

A nonzero polynomial in letters between which no relation holds is not zero. Roots are first multiplied away
by their conjugates. Where relations may be left that no rule uses, a remainder shows nothing.
"""

from __future__ import annotations

from derivation.paper.algebra import Atom, Monomial, Poly, cleared
from derivation.paper.byparts import ADJOINT, MODES, is_known
from derivation.paper.meanings import FIELDS, STRAINS
from derivation.paper.theory import Theory, without_powers

#: The components of any two vectors.
VECTORS = tuple(f"{name}{k}" for name in ("Psi", "Phi") for k in range(3))
#: Roots that are multiplied away, one after the other.
MOST_ROOTS = 6


def is_decisive(theory: Theory, p: Poly) -> bool:
    """Whether a p that is left, not zero, is one that does not vanish."""
    p = _without_roots(p)
    if not p or any(a.kind in ("sqrt", "inverse") for a in p.atoms):
        return False
    if any(a.kind == "exp" and any(b.name == "theta" for b in a.arg.atoms) for a in p.atoms):
        return False  # the sine and cosine of theta are letters of their own
    exact = {a for a in p.atoms if a.kind == "exact" and not a.name.startswith("any")}
    if exact and any(a.kind == "field" for a in p.atoms):
        return False  # a quantity and its expansion
    if any(a.kind == "exact" for m in p.terms for a, _ in m):
        p = theory.in_fields(p)
    return bool(p) and all(map(_is_free, p.terms))


def _without_roots(p: Poly) -> Poly:
    """p times its conjugates q - s sqrt(r) of q + s sqrt(r); zero may be a root's other sign."""
    for _ in range(MOST_ROOTS):
        root = next((a for m in p.terms for a, _ in m if a.kind == "sqrt"), None)
        if root is None:
            return p
        p = without_powers(p, root, root.arg)
        single = (root, 1)
        plain = Poly({m: c for m, c in p.terms.items() if single not in m})
        beside = Poly({m - {single}: c for m, c in p.terms.items() if single in m})
        p = cleared(plain * plain - root.arg * beside * beside) if plain else cleared(beside)
    return p


def _is_free(m: Monomial) -> bool:
    """A product of letters between which no relation is left."""
    integrals = [a for a, _ in m if a.kind == "integral"]
    if any(not (is_known(frozenset([(a, 1)])) or _is_generic(a)) for a in integrals):
        return False
    names = {a.name for a, _ in m if a.kind == "shape" and a.place is None}
    if names & {*ADJOINT} and names & {*MODES}:
        return False  # their concomitant does not depend on u
    return all(_is_initial(a) for a, _ in m if a.kind == "exact")


def _is_generic(a: Atom) -> bool:
    """An integral over functions of which nothing is known, and shapes beside them."""
    generic = {b for b in a.arg.atoms if b.name in (*STRAINS, *VECTORS)}
    shapes = all(b.kind == "shape" for b in a.arg.atoms - generic)
    return bool(generic) and shapes and not any(b.u or b.tau for b in generic)


def _is_initial(a: Atom) -> bool:
    """What may be chosen at one moment: x, y, theta along the rod, their slopes at the clamp, their speeds at
    the tip, where the strains follow from the load."""
    if a.name.startswith("any"):
        return True
    if a.name not in (*FIELDS, "cos", "sin"):
        return False
    return {None: not a.tau, 0: a.u <= 1 and not a.tau, 1: not a.u and a.tau <= 1}[a.place]
