"""Elements of the derivation's rings as Laurent polynomials, by the names of their generators."""

from __future__ import annotations

import re

from sympy import QQ_I
from sympy.polys.rings import PolyElement

from derivation.paper.algebra import Atom, Poly, normal

_JET = re.compile(r"(x|y|theta)([0-9])(?:_(u*)((?:tau)*)(T*))?")
_SHAPE = re.compile(r"(Theta|Y|H|X0|X2|P0|P2|Psi_Y|Psi_Theta)(_bar)?(_tip)?(?:_(u+))?")
_EXACT = re.compile(r"(x|y|theta|cos|sin|h1|h2|Pi|v1|v2|Omega|F1|F2|M)(?:_(u*)(t*))?")


def from_ring(p: PolyElement) -> Poly:
    """An element of one of the derivation's rings, by the names of its generators."""
    images = [_generator(str(g)) for g in p.ring.gens]
    return Poly.of(
        (normal((a, s * e) for (a, s), e in zip(images, m, strict=True)), QQ_I.convert(c))
        for m, c in p.terms()
    )


def _generator(name: str) -> tuple[Atom, int]:
    """The atom of a generator, and the sign of its power (``k1_inv`` is k1 to the power -1)."""
    if m := _JET.fullmatch(name):
        f, n, u, tau, slow = m.groups(default="")
        return Atom("field", f, int(n), len(u), len(tau) // 3, len(slow)), 1
    if m := _SHAPE.fullmatch(name):
        shape, bar, tip, u = m.groups(default="")
        return Atom("shape", shape, u=len(u), bar=bool(bar), place=1 if tip else None), 1
    if m := re.fullmatch(r"A(_T)?(_bar)?", name):
        return Atom("amplitude", "A", slow=int(bool(m[1])), bar=bool(m[2])), 1
    if m := _EXACT.fullmatch(name):
        f, u, t = m.groups(default="")
        return Atom("exact", f, u=len(u), tau=len(t)), 1
    if name.endswith("_inv"):
        return Atom("constant", name[:-4]), -1
    return Atom("constant", name), 1
