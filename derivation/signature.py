"""How derived formulas become functions: which arguments they take, which letters are spelt out.

A formula over the ring of modes takes the shapes it contains, the eigenvalue and the parameters, in a fixed
order; a shape's conjugate is not an argument but is computed. The letters of the straight rod (nu, mu, K1,
the compression) are spelt out, so that callers pass parameters only. Where nu cannot be given in the force it
is an argument. Under a distributed load u is one, and such a nu is its value there, nu_tip that at the tip.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import replace

import sympy
from sympy import Expr, Integer, Symbol
from sympy.polys.rings import PolyElement

from derivation.emit.program import Argument, Function
from derivation.jets import JetRing
from derivation.pipeline import Derivation
from derivation.present import expression, with_eigenvalue
from derivation.symbols import BAR, SHAPES, symbol

SCALAR = "(...)"
NODES = "(..., nodes)"

#: Arguments of formulas that are not shapes themselves.
_MEANING = {
    "Y_u": "derivative of Y",
    "Y_uu": "second derivative of Y",
    "Theta_u": "derivative of Theta",
    "Theta_uu": "second derivative of Theta",
    "Theta_tip": "Theta at u = 1",
    "Y_tip": "Y at u = 1",
    "Psi_Y_tip": "Psi_Y at u = 1",
    "Psi_Theta_tip": "Psi_Theta at u = 1",
    "X0_u": "derivative of X0",
    "X2_u": "derivative of X2",
    "u": "material coordinate",
    "g1": "cubic forcing of the y row",
    "g2": "detuning forcing of the y row",
    "g3": "cubic forcing of the theta row",
    "g4": "detuning forcing of the theta row",
}
#: The order of shapes in a signature.
_ORDER = (
    *("u", "Psi_Y", "Psi_Theta", "Y", "Y_u", "Y_uu", "Theta", "Theta_u", "Theta_uu", "H"),
    *("X0_u", "X2_u", "X2", "P0", "P2", "Y_tip", "Theta_tip", "Psi_Y_tip", "Psi_Theta_tip"),
    *("g1", "g2", "g3", "g4"),
)
_BASIC = {
    "k1": "stretch stiffness ratio k1 L^2/k3",
    "k2": "shear stiffness ratio k2 L^2/k3",
    "gamma3": "rotational drag ratio gamma3/(gamma2 L^2)",
    "gamma1": "translational drag ratio gamma1/gamma2",
}
_LAM = "i omega at the threshold, purely imaginary"


def scalar(name: str, doc: str) -> Argument:
    """A number, one for each rod; it leaves the signatures of functions that do not need it."""
    return Argument(name, symbol(name), doc, SCALAR, parameter=True)


def nodal(name: str, doc: str = "") -> Argument:
    """A function of u given at nodes."""
    return Argument(name, symbol(name), doc or _MEANING.get(name) or SHAPES[name][1], NODES)


def needs_namespace(formulas: Iterable[Expr]) -> bool:
    """Whether formulas hold a function (a square root is one) that plain arithmetic does not have."""
    return any(
        e.has(sympy.sin, sympy.cos, sympy.exp, sympy.log, sympy.E)
        or any(not power.exp.is_Integer for power in e.atoms(sympy.Pow))
        for e in formulas
    )


class Signatures:
    """Makes the functions of one derivation.

    Attributes:
        parameters: the model's parameters as arguments, in their order.
        implicit: whether nu is an argument because it cannot be given in the force.
    """

    def __init__(self, d: Derivation) -> None:
        self._d = d
        hierarchy, law = d.hierarchy, d.law
        straight = hierarchy.straight
        force, u, load, nu = (symbol(n) for n in ("force", "u", "load", "nu"))
        # Under a distributed load: load' = b and load(1) = 0.
        compression = force if law.uniform else (law.body_load[0] * (u - 1)).expand()
        formulas: dict[Symbol, Expr] = {load: compression}
        formulas |= {symbol(inverse): 1 / symbol(letter) for letter, inverse in law.inverses.items()}
        if straight.nu is not None:
            formulas[nu] = expression(hierarchy.ring, straight.nu).xreplace(formulas)
        formulas |= {symbol(name): e.xreplace(formulas) for name, e in law.constants.items()}
        formulas[symbol("mu")] = expression(hierarchy.ring, straight.mu).xreplace(formulas)
        # An inverse may be that of a letter that has a formula itself.
        self._formulas = {s: e.xreplace(formulas) for s, e in formulas.items()}
        self.implicit = straight.nu is None
        own = tuple(scalar(p.name, p.meaning) for p in d.model.parameters)
        self._at_tip: dict[Symbol, Expr] = {u: Integer(1)}
        stretch = [scalar("nu", "stretch of the straight rod")] if self.implicit else []
        if self.implicit and not law.uniform:
            at_node = replace(nodal("nu", "stretch of the straight rod at u"), parameter=True)
            stretch = [at_node, scalar("nu_tip", "stretch of the straight rod at u = 1")]
            self._at_tip[nu] = symbol("nu_tip")
        basic = tuple(replace(scalar(name, doc), carrier=name == "k1") for name, doc in _BASIC.items())
        self.parameters = (*basic, *own, *stretch, scalar("force", "follower force F L^2/k3"))

    def spell(self, e: Expr) -> Expr:
        """Replace the letters of the straight rod by what they stand for."""
        return e.xreplace(self._formulas)

    def formula(self, p: PolyElement, at_tip: bool = False, ring: JetRing | None = None) -> Expr:
        """An element of the ring of modes (or ``ring``), i omega as lam, spelt out, grouped for reading."""
        ring = ring or self._d.modes.ring
        spelt = self.spell(expression(ring, with_eigenvalue(ring, p)))
        return spelt.xreplace(self._at_tip) if at_tip else spelt

    def function(
        self,
        name: str,
        doc: str,
        labels: tuple[str, ...],
        outputs: dict[str, Expr],
        shapes: Sequence[Argument] | None = None,
    ) -> Function:
        """A function of shapes, the eigenvalue and parameters: of those its formulas contain.

        ``shapes`` are the shapes to choose from, in order; by default those of the theory at order 3.
        """
        used = {s.name for e in outputs.values() for s in e.free_symbols}
        plain = {n.replace(BAR, "") for n in used}
        chosen = self._shapes(used) if shapes is None else tuple(a for a in shapes if a.name in plain)
        arguments = (*chosen, scalar("lam", _LAM), *self.parameters)
        conjugates, namespace = self._conjugates(used), needs_namespace(outputs.values())
        return Function(name, doc, labels, arguments, tuple(outputs.items()), conjugates, namespace)

    @staticmethod
    def _shapes(used: Iterable[str]) -> tuple[Argument, ...]:
        plain = {name.replace(BAR, "") for name in used}
        return tuple(
            Argument(n, symbol(n), _MEANING[n], SCALAR) if n.endswith("_tip") else nodal(n)
            for n in _ORDER
            if n in plain
        )

    @staticmethod
    def _conjugates(used: Iterable[str]) -> tuple[tuple[Symbol, Symbol], ...]:
        return tuple((symbol(n), symbol(n.replace(BAR, ""))) for n in sorted(used) if BAR in n)
