"""What the letters of a paper mean: every quantity as the object that the derivation made of it.

Meanings are read off the records of :class:`derivation.pipeline.Derivation`. No formula of the theory stands
here.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import cached_property
from typing import Any

from sympy import QQ_I, Expr
from sympy.polys.rings import PolyElement

from derivation.errors import ModelError
from derivation.jets import from_expr, jet_ring
from derivation.paper.algebra import (
    Atom,
    I,
    Monomial,
    Poly,
    U,
    atom,
    constant,
    exp,
    poly,
    rational,
)
from derivation.paper.carry import from_ring
from derivation.pipeline import Derivation
from derivation.resonance import Transformation
from derivation.symbols import symbol

FIELDS = ("x", "y", "theta")
STRAINS = ("h1", "h2", "Pi")
VELOCITIES = ("v1", "v2", "Omega")
STRESSES = ("F1", "F2", "M")
LOADS = ("f1", "f2", "m")
ORDERS = (1, 2, 3)
Vector = tuple[Poly, ...]


class Meanings:
    """What each quantity is, made once from a derivation."""

    def __init__(self, derivation: Derivation) -> None:
        self.d = derivation

    def of_order(self, quantity: str, n: int, *, transformed: bool = True) -> Poly | None:
        """The coefficient of epsilon^n of a quantity; None when the theory has none of that name.

        At order 3 the forcings are those of the transformed variables, unless ``transformed`` is False.
        """
        k = self.d.kinematics
        table: dict[str, Callable[[], PolyElement]] = {}
        for names, series in ((STRAINS, k.strains), (VELOCITIES, k.velocities)):
            table |= {q: lambda s=s: s[n] for q, s in zip(names, series, strict=True)}  # type: ignore[misc]
        if quantity in FIELDS:
            base = {"x": constant("nu") * constant("u")}
            return base.get(quantity, poly(0)) if n == 0 else atom(Atom("field", quantity, n))
        if n == 0 and quantity in STRESSES:
            return {"F1": -constant("force")}.get(quantity, poly(0))
        if n in ORDERS:
            order = self.d.hierarchy[n]
            table |= {q: lambda s=s: s for q, s in zip(STRESSES, order.stresses, strict=True)}  # type: ignore[misc]
            table |= {q: lambda s=s: s for q, s in zip(("f1", "f2", "f3"), order.forcing, strict=True)}  # type: ignore[misc]
            if quantity == "b1":
                return from_ring(order.slopes[0]).at(1)
            if n == 3 and transformed and quantity in ("f1", "f2", "f3", "y_hat", "theta_hat"):
                return self._transformed(quantity)
        return from_ring(table[quantity]()) if quantity in table else None

    def _transformed(self, quantity: str) -> Poly:
        """Order 3 in the transformed variables: x is left as it is and is not forced."""
        third = self.transformation
        assert third is not None
        if quantity == "f1":
            return self.vanishing(from_ring(self.d.hierarchy[3].forcing[0]), 3)
        if quantity == "y_hat":
            return atom(Atom("field", "y", 3)) - from_ring(third.rest).at(1) * constant("u")
        if quantity == "theta_hat":
            return atom(Atom("field", "theta", 3)) - from_ring(third.local)
        return self.in_time(from_ring(third.forcing[0 if quantity == "f2" else 1]))

    @cached_property
    def shapes(self) -> dict[str, Poly]:
        """H, P0 and P2 in Theta, Y, X0, X2 and their derivatives."""
        second, ring = self.d.second, self.d.modes.ring
        shear = from_ring(ring["Y_u"]) - from_ring(ring["nu"] * ring["Theta"])
        found = {"H": shear, "P0": from_ring(second.mean.tension), "P2": from_ring(second.harmonic.tension)}
        return {name: p.rewrite(lambda a: self.shape_meaning(a, found)) for name, p in found.items()}

    @cached_property
    def g(self) -> dict[str, Poly]:
        """g1 ... g4 in the same."""
        names = {f"g{k}": from_ring(g) for k, g in enumerate(self.transformation.g, 1)}
        return {name: p.rewrite(lambda a: self.shape_meaning(a, self.shapes)) for name, p in names.items()}

    def shape_meaning(self, a: Atom, found: dict[str, Poly]) -> Poly | None:
        if a.kind != "shape" or a.name not in ("H", "P0", "P2"):
            return None
        value = found[a.name]
        for _ in range(a.u):
            value = value.derive("u")
        if a.bar:
            value = value.conjugate()
        return value if a.place is None else value.at(a.place)

    @cached_property
    def transformation(self) -> Transformation:
        """The variables of order 3 in which a paper of this notation states its cubic forcing.

        Raises:
            ModelError: if the rod's load allows no such variables.
        """
        if self.d.third.transformed is None:
            raise ModelError(
                f"{self.d.model.name}: its load mixes fields of order 3; no transformed variables"
            )
        return self.d.third.transformed

    @cached_property
    def ansatz(self) -> dict[tuple[str, int], Poly]:
        """(field, order) -> the wave that is inserted for it."""
        return {key: self.in_time(from_ring(p)) for key, p in self.d.second.modes.fields.items()}

    def vanishing(self, p: Poly, n: int) -> Poly:
        """Fields of orders below n that the solutions found there set to zero."""
        zero = {(f, k) for (f, k), wave in self.ansatz.items() if not wave and k < n}
        return p.map(lambda a: poly(0) if a.kind == "field" and (a.name, a.order) in zero else None)

    def in_time(self, p: Poly) -> Poly:
        """Write e^{i m omega t}, which the derivation leaves to the degree in A."""
        rate = I * constant("omega") * constant("t")

        def wave(m: Monomial) -> Poly:
            turns = sum((-e if a.bar else e) for a, e in m if a.kind == "amplitude")
            return exp(rate * turns)

        return sum((Poly({m: c}) * wave(m) for m, c in p.terms.items()), poly(0))

    @cached_property
    def operator(self) -> tuple[Vector, ...]:
        """Gamma^{-1} M as a matrix of polynomials in the operator d/du."""
        rows = []
        for row, weight in zip(self.d.hierarchy[1].linear, self.weights, strict=True):
            entries = [poly(0)] * 3
            for m, c in from_ring(row).terms.items():
                (jet,) = (a for a, _ in m if a.kind == "field")
                if not jet.tau:
                    rest = m - {(jet, 1)}
                    op = atom(Atom("operator", "u")) ** jet.u
                    entries[FIELDS.index(jet.name)] -= Poly({rest: c}) * op * weight.inverse()
            rows.append(tuple(entries))
        return tuple(rows)

    @cached_property
    def adjoint_operator(self) -> tuple[Vector, ...]:
        """Gamma^{-1} M^dagger; its longitudinal row, which no transverse mode meets, is that of M."""
        rows = [self.operator[0]]
        for row, weight in zip(self.d.adjoint.operator, self.weights[1:], strict=True):
            entries = [poly(0)] * 3
            for m, c in from_ring(row).conjugate().terms.items():
                (jet,) = (a for a, _ in m if a.kind == "shape")
                place = 1 + ("Psi_Y", "Psi_Theta").index(jet.name)
                op = atom(Atom("operator", "u")) ** jet.u
                entries[place] += Poly({m - {(jet, 1)}: c}) * op * weight.inverse()
            rows.append(tuple(entries))
        return tuple(rows)

    @cached_property
    def weights(self) -> Vector:
        """The diagonal of Gamma: the coefficients of d/dtau in the balance laws of order 1."""
        found = []
        for f, row in zip(FIELDS, self.d.hierarchy[1].linear, strict=True):
            rate = Atom("field", f, 1, tau=1)
            found.append(
                Poly.of((m - {(rate, 1)}, c) for m, c in from_ring(row).terms.items() if (rate, 1) in m)
            )
        return tuple(found)

    @cached_property
    def resonant(self) -> tuple[Poly, Poly]:
        """The resonant forcing of y and theta, in A and its slow derivative, without e^{i omega t}."""
        r = self.transformation.resonant
        a, a_bar = atom(Atom("amplitude", "A")), atom(Atom("amplitude", "A", bar=True))
        slow = atom(Atom("amplitude", "A", slow=1))
        y, theta = (
            a**2 * a_bar * from_ring(c) + constant("Delta") * a * from_ring(f) + slow * from_ring(s)
            for c, f, s in zip(r.cubic, r.detuning, r.slow, strict=True)
        )
        return y, theta

    @cached_property
    def landau(self) -> dict[str, Poly]:
        """alpha and beta as quotients of integrals."""
        c = self.d.landau
        assert c.cubic is not None
        assert c.detuning is not None
        weight = self.norm.inverse()
        return {
            "alpha": integral(from_ring(c.cubic.integrand)) * weight,
            "beta": integral(from_ring(c.detuning.integrand)) * weight,
        }

    @cached_property
    def norm(self) -> Poly:
        """The denominator of alpha and beta."""
        return integral(from_ring(self.d.landau.norm.integrand))

    def _of_model(self, e: Expr, *names: str) -> Poly:
        """A formula of the model, polynomial in its parameters and these quantities.

        Raises:
            ModelError: if it is no polynomial.
        """
        ring = jet_ring([*names, *self.d.law.parameters])
        try:
            return from_ring(from_expr(e.expand(), ring))
        except ValueError as problem:
            raise ModelError(f"{self.d.model.name}: {problem}") from None

    @cached_property
    def stress_law(self) -> Vector:
        """(F1, F2, M) = grad W in the exact strains."""
        return tuple(_exact(self._of_model(self.d.model.energy.diff(symbol(q)), *STRAINS)) for q in STRAINS)

    @cached_property
    def energy(self) -> Poly:
        """W in the exact strains."""
        return _exact(self._of_model(self.d.model.energy, *STRAINS))

    @cached_property
    def drag(self) -> Vector:
        """Minus the body force and torque, in the exact strains and velocities."""
        return tuple(_exact(self._of_model(e, *STRAINS, *VELOCITIES)) for e in self.d.model.drag)

    @cached_property
    def tip_load(self) -> Vector:
        """The stresses imposed at u = 1."""
        return tuple(
            _exact(self._of_model(e, "cos", "sin", "theta", *VELOCITIES)).at(1) for e in self.d.model.tip_load
        )

    def kinematics(self, quantity: str) -> Poly:
        """An exact strain or velocity in x, y, theta."""
        table = dict(
            zip((*STRAINS, *VELOCITIES), (*self.d.exact.strains, *self.d.exact.velocities), strict=True)
        )
        return from_ring(table[quantity])


def _exact(p: Poly) -> Poly:
    """The quantities of a law as the exact ones."""
    names = (*STRAINS, *VELOCITIES, "cos", "sin", "theta")
    return p.map(lambda a: atom(Atom("exact", a.name)) if a.name in names else None)


def integral(p: Poly) -> Poly:
    """int_0^1 p du as constants times integrals of single products; those of powers of u are known."""
    total: list[tuple[Monomial, Any]] = []
    for m, c in p.terms.items():
        inside = frozenset(
            (a, e) for a, e in m if a == U or (a.kind in ("shape", "field", "exact") and a.place is None)
        )
        unit = Poly({inside: QQ_I.one})
        power = dict(inside).get(U, 0)
        known = inside <= {(U, power)} and power >= 0
        value = rational(1, power + 1) if known else atom(Atom("integral", arg=unit))
        total += (Poly({m - inside: c}) * value).terms.items()
    return Poly.of(total)


def normal_integrals(p: Poly) -> Poly:
    """Integrals whose integrands were rewritten, in their normal form again."""
    return p.map(lambda a: integral(a.arg) if a.kind == "integral" else None)
