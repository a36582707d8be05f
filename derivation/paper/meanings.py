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

from derivation.jets import from_expr, jet_ring
from derivation.paper.algebra import (
    Atom,
    I,
    Monomial,
    Poly,
    U,
    atom,
    constant,
    depends_on_u,
    exp,
    poly,
    rational,
)
from derivation.paper.carry import from_ring
from derivation.paper.reasons import UndecidedError
from derivation.pipeline import Derivation
from derivation.resonance import Transformation
from derivation.solvability import Functional
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

    def carried(self, p: PolyElement) -> Poly:
        """An element of one of the derivation's rings; what varies along the straight rod in its u."""
        found = from_ring(p)
        if not self.profiles:
            return found
        return found.map(lambda a: self.profiles.get(a.name) if a.kind == "constant" else None)

    def named(self, name: str) -> Poly:
        """A constant of the theory by its name; nu and mu are none where they vary along the straight rod."""
        return self.profiles.get(name, constant(name))

    @cached_property
    def profiles(self) -> dict[str, Poly]:
        """nu, mu and the compression along a straight rod that is not uniform, as functions of u."""
        law, straight = self.d.law, self.d.hierarchy.straight
        if law.uniform:
            return {}
        load = self._of_model(law.body_load[0]) * (atom(U) - 1)
        along = {"load": load}
        for name, value in (("nu", straight.nu), ("mu", straight.mu)):
            assert value is not None
            along[name] = from_ring(value).map(lambda a: along.get(a.name))
        return along

    def of_order(self, quantity: str, n: int, *, transformed: bool = True) -> Poly | None:
        """The coefficient of epsilon^n of a quantity; None when the theory has none of that name.

        At order 3 the forcings are those of the transformed variables, unless ``transformed`` is False.
        """
        k = self.d.kinematics
        table: dict[str, Callable[[], PolyElement]] = {}
        for names, series in ((STRAINS, k.strains), (VELOCITIES, k.velocities)):
            table |= {q: lambda s=s: s[n] for q, s in zip(names, series, strict=True)}  # type: ignore[misc]
        if quantity in FIELDS:
            if n == 0:
                return _integrated(self.named("nu")) if quantity == "x" else poly(0)
            return atom(Atom("field", quantity, n))
        if n == 0 and quantity in STRESSES:
            return -self.carried(self.d.hierarchy.straight.load) if quantity == "F1" else poly(0)
        if n in ORDERS:
            order = self.d.hierarchy[n]
            table |= {q: lambda s=s: s for q, s in zip(STRESSES, order.stresses, strict=True)}  # type: ignore[misc]
            table |= {q: lambda s=s: s for q, s in zip(("f1", "f2", "f3"), order.forcing, strict=True)}  # type: ignore[misc]
            if quantity == "b1":
                return self.carried(order.slopes[0]).at(1)
            if n == 3 and transformed and quantity in ("f1", "f2", "f3", "y_hat", "theta_hat"):
                return self._transformed(quantity)
        return self.carried(table[quantity]()) if quantity in table else None

    def _transformed(self, quantity: str) -> Poly:
        """Order 3 in the transformed variables: x is left as it is and is not forced."""
        third = self.transformation
        if quantity == "f1":
            return self.vanishing(self.carried(self.d.hierarchy[3].forcing[0]), 3)
        if quantity == "y_hat":
            return atom(Atom("field", "y", 3)) - self.carried(third.rest).at(1) * constant("u")
        if quantity == "theta_hat":
            return atom(Atom("field", "theta", 3)) - self.carried(third.local)
        return self.in_time(self.carried(third.forcing[0 if quantity == "f2" else 1]))

    @cached_property
    def shapes(self) -> dict[str, Poly]:
        """H, P0 and P2 in Theta, Y, X0, X2 and their derivatives."""
        second, ring = self.d.second, self.d.modes.ring
        shear = self.carried(ring["Y_u"]) - self.carried(ring["nu"] * ring["Theta"])
        found = {
            "H": shear,
            "P0": self.carried(second.mean.tension),
            "P2": self.carried(second.harmonic.tension),
        }
        return {name: p.rewrite(lambda a: self.shape_meaning(a, found)) for name, p in found.items()}

    @cached_property
    def g(self) -> dict[str, Poly]:
        """g1 ... g4 in the same."""
        names = {f"g{k}": self.carried(g) for k, g in enumerate(self.transformation.g, 1)}
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
            UndecidedError: if the rod's load allows no such variables.
        """
        if self.d.third.transformed is None:
            raise UndecidedError(
                f"the load of {self.d.model.name} mixes fields of order 3 into its conditions: there are no "
                "transformed variables, and no g1 ... g4"
            )
        return self.d.third.transformed

    @cached_property
    def ansatz(self) -> dict[tuple[str, int], Poly]:
        """(field, order) -> the wave that is inserted for it."""
        return {key: self.in_time(self.carried(p)) for key, p in self.d.second.modes.fields.items()}

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
            for m, c in self.carried(row).terms.items():
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
            for m, c in self.carried(row).conjugate().terms.items():
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
                Poly.of((m - {(rate, 1)}, c) for m, c in self.carried(row).terms.items() if (rate, 1) in m)
            )
        return tuple(found)

    @cached_property
    def resonant(self) -> tuple[Poly, Poly]:
        """The resonant forcing of y and theta, in A and its slow derivative, without e^{i omega t}."""
        r = self.transformation.resonant
        a, a_bar = atom(Atom("amplitude", "A")), atom(Atom("amplitude", "A", bar=True))
        slow = atom(Atom("amplitude", "A", slow=1))
        y, theta = (
            a**2 * a_bar * self.carried(c) + constant("Delta") * a * self.carried(f) + slow * self.carried(s)
            for c, f, s in zip(r.cubic, r.detuning, r.slow, strict=True)
        )
        return y, theta

    @cached_property
    def landau(self) -> dict[str, Poly]:
        """alpha and beta as quotients of integrals; without transformed variables, end terms stay."""
        c = self.d.landau
        weight = self.norm.inverse()
        pairs = {"alpha": c.cubic or c.cubic_kept, "beta": c.detuning or c.detuning_kept}
        return {name: self._functional(value) * weight for name, value in pairs.items()}

    @cached_property
    def norm(self) -> Poly:
        """The denominator of alpha and beta."""
        return self._functional(self.d.landau.norm)

    def _functional(self, f: Functional) -> Poly:
        """An integral and its end terms."""
        return integral(self.carried(f.integrand)) + self.carried(f.boundary)

    def _of_model(self, e: Expr, *names: str) -> Poly:
        """A formula of the model, polynomial in its parameters and these quantities.

        Raises:
            UndecidedError: if it is no polynomial.
        """
        ring = jet_ring([*names, *self.d.law.parameters])
        try:
            return from_ring(from_expr(e.expand(), ring))
        except ValueError:
            raise UndecidedError(
                f"{self.d.model.name}: {e} is no polynomial, and only those are compared"
            ) from None

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
        """The drag, in the exact strains and velocities."""
        return tuple(_exact(self._of_model(e, *STRAINS, *VELOCITIES)) for e in self.d.model.drag)

    @cached_property
    def body_force(self) -> Vector:
        """The body force and torque: the load along the rod minus the drag."""
        return tuple(
            self._of_model(e) - drag for e, drag in zip(self.d.model.body_load, self.drag, strict=True)
        )

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
        return self.carried(table[quantity])


def _exact(p: Poly) -> Poly:
    """The quantities of a law as the exact ones."""
    names = (*STRAINS, *VELOCITIES, "cos", "sin", "theta")
    return p.map(lambda a: atom(Atom("exact", a.name)) if a.name in names else None)


def _integrated(p: Poly) -> Poly:
    """int_0^u of a polynomial in u."""
    total = poly(0)
    for m, c in p.terms.items():
        power = dict(m).get(U, 0)
        total += Poly({m: c}) * atom(U) * rational(1, power + 1)
    return total


def integral(p: Poly) -> Poly:
    """int_0^1 p du as constants times integrals of single products; those of powers of u are known.

    Raises:
        UndecidedError: for an exponential, a root or a quotient that depends on u.
    """
    total: list[tuple[Monomial, Any]] = []
    for m, c in p.terms.items():
        inside = frozenset((a, e) for a, e in m if depends_on_u(a))
        if any(isinstance(a.arg, Poly) for a, _ in inside):
            raise UndecidedError("an integral over an exponential, a root or a quotient that depends on u")
        unit = Poly({inside: QQ_I.one})
        power = dict(inside).get(U, 0)
        known = inside <= {(U, power)} and power >= 0
        value = rational(1, power + 1) if known else atom(Atom("integral", arg=unit))
        total += (Poly({m - inside: c}) * value).terms.items()
    return Poly.of(total)


def normal_integrals(p: Poly) -> Poly:
    """Integrals whose integrands were rewritten, in their normal form again."""
    return p.map(lambda a: integral(a.arg) if a.kind == "integral" else None)
