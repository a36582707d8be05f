"""What the letters of a paper mean: every quantity as the object that the derivation made of it.

Meanings are read off the records of :class:`derivation.pipeline.Derivation`; so are the rules by which an
expression is reduced. No formula of the theory stands here.
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
    from_ring,
    harmonic,
    poly,
    rational,
)
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


class Theory:
    """Meanings and rules, made once from a derivation."""

    def __init__(self, derivation: Derivation) -> None:
        self.d = derivation

    # Meanings -----------------------------------------------------------------------------------------

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
        return {name: p.rewrite(lambda a: self._shape_meaning(a, found)) for name, p in found.items()}

    @cached_property
    def g(self) -> dict[str, Poly]:
        """g1 ... g4 in the same."""
        names = {f"g{k}": from_ring(g) for k, g in enumerate(self.transformation.g, 1)}
        return {name: p.rewrite(lambda a: self._shape_meaning(a, self.shapes)) for name, p in names.items()}

    def _shape_meaning(self, a: Atom, found: dict[str, Poly]) -> Poly | None:
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
        norm = integral(from_ring(c.norm.integrand))
        return {
            "alpha": integral(from_ring(c.cubic.integrand)) * norm.inverse(),
            "beta": integral(from_ring(c.detuning.integrand)) * norm.inverse(),
        }

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

    @cached_property
    def eigenvalue_slope(self) -> str:
        """The name of d lambda/dF at the threshold: that of beta, which it is proved to be.

        lambda Gamma phi = M phi, differentiated in the force and projected on the adjoint mode, gives
        lambda' (Psi, phi)_Gamma = int Psi^dagger (M' - lambda Gamma') phi du + [Q(Psi, phi')]; at the tip the
        derivative of the mode obeys y' - nu theta = nu' Theta, so the end term is k2 Psi_Y(1)^* nu' Theta(1).
        These are the integrand and the end term that the expansion gives for the detuning.

        Raises:
            ModelError: if they are not, as with another tip load.
        """
        rate = I * constant("omega")
        bulk = poly(0)
        for k, (name, row) in enumerate(zip(("Y", "Theta"), self.d.adjoint.primal, strict=True), 1):
            slope = self.by_force(from_ring(row)) - rate * self.by_force(self.weights[k]) * atom(
                Atom("shape", name)
            )
            bulk += atom(Atom("shape", f"Psi_{name}", bar=True)) * slope
        theta, psi = atom(Atom("shape", "Theta", place=1)), atom(Atom("shape", "Psi_Y", bar=True, place=1))
        end = constant("k2") * psi * self.by_force(constant("nu")) * theta
        kept = self.d.landau.detuning_kept
        for ours, theirs in ((bulk, kept.integrand), (end, kept.boundary)):
            if self.canonical(self.by_equations(ours - from_ring(theirs))):
                raise ModelError(f"{self.d.model.name}: d lambda/dF is not shown to be beta")
        return "beta"

    def by_force(self, p: Poly) -> Poly:
        """The derivative in the force of coefficients, nu and mu included."""
        return self.canonical(p).derive("force")

    # Rules --------------------------------------------------------------------------------------------

    @cached_property
    def _tops(self) -> dict[tuple[str, str, int], Poly]:
        """Second u-derivatives by the equations: of fields from the balance laws, of shapes from theirs."""
        rules: dict[tuple[str, str, int], Poly] = {}
        for n in ORDERS:
            for f, row in zip(FIELDS, self.d.hierarchy[n].balance, strict=True):
                rules["field", f, n] = _solve(from_ring(row), Atom("field", f, n, u=2))
        interior = self.d.adjoint.modes.interior | self.d.second.modes.interior
        for g, value in interior.items():
            (m,) = from_ring(g).terms
            ((a, _),) = m
            if a.u == 2 and not a.bar:
                rules["shape", a.name, 0] = from_ring(value).rewrite(
                    lambda b: self._shape_meaning(b, self.shapes)
                )
        return rules

    @cached_property
    def _ends(self) -> dict[Atom, Poly]:
        """Values at the ends: the rod's conditions order by order, those of the modes and corrections."""
        rules: dict[Atom, Poly] = {}
        for g, value in self.d.hierarchy.tip_rules.items():
            (m,) = from_ring(g).terms
            ((a, _),) = m
            rules[a.replace(place=1)] = from_ring(value).at(1)
            if a.order == 1 and a.name != "x":  # the mode obeys the conditions of order 1
                rules[_of_mode(a).replace(place=1)] = (
                    from_ring(value).map(lambda b: atom(_of_mode(b)) if b.kind == "field" else None).at(1)
                )
        for n in ORDERS:
            rules |= {Atom("field", f, n, place=0): poly(0) for f in FIELDS}
        for c in (self.d.second.mean, self.d.second.harmonic):
            name = f"X{c.harmonic}"
            rules[Atom("shape", name, u=1, place=1)] = from_ring(c.tip_slope).at(1)
            rules[Atom("shape", name, place=0)] = poly(0)
        rules |= {Atom("shape", s, place=0): poly(0) for s in ("Y", "Theta", "Psi_Y", "Psi_Theta")}
        rules[Atom("shape", "Y", place=1)] = poly(1)  # the normalisation
        for g, value in self.d.adjoint.modes.tip.items():
            (m,) = from_ring(g).terms
            ((a, _),) = m
            if a.name.startswith("Psi") and a.u and not a.bar:
                rules[a.replace(place=1)] = from_ring(value).at(1)
        return rules

    @cached_property
    def _constants(self) -> dict[str, Poly]:
        """nu and mu by the base state; the saturated amplitude and what follows from it."""
        amplitude, straight = self.d.amplitude, self.d.hierarchy.straight
        detuning = constant("epsilon") ** 2 * constant("Delta")
        slope = from_ring(amplitude.sigma[0]) * from_ring(amplitude.sigma[1]).inverse()
        delta = constant("Delta").inverse()
        return {
            **({"nu": from_ring(straight.nu)} if straight.nu is not None else {}),
            "mu": from_ring(straight.mu),
            "R_T": from_ring(amplitude.radial),
            "phase_T": from_ring(amplitude.phase),
            "sigma": slope,
            "omega_branch": constant("omega") + slope * delta * detuning,
            "A_tip": 2 * _root(self.saturated * delta * detuning),
        }

    @cached_property
    def saturated(self) -> Poly:
        """R*^2."""
        return from_ring(self.d.amplitude.saturated[0]) * from_ring(self.d.amplitude.saturated[1]).inverse()

    def vanishing(self, p: Poly, n: int) -> Poly:
        """Fields of orders below n that the solutions found there set to zero."""
        zero = {(f, k) for (f, k), wave in self.ansatz.items() if not wave and k < n}
        return p.map(lambda a: poly(0) if a.kind == "field" and (a.name, a.order) in zero else None)

    def by_exact_laws(self, p: Poly) -> Poly:
        """Modulo the balance laws (eq:dynamicsfull), the rod's conditions at its ends and its stress law."""
        names = (*STRAINS, *VELOCITIES, *STRESSES)
        h1, h2, bend, _, _, _, f1, f2, _ = (atom(Atom("exact", q)) for q in names)
        turning = (bend * f2, -bend * f1, h2 * f1 - h1 * f2)
        rules = {Atom("exact", f, u=1): d + t for f, d, t in zip(STRESSES, self.drag, turning, strict=True)}
        rules |= {Atom("exact", f, place=1): load for f, load in zip(STRESSES, self.tip_load, strict=True)}
        rules |= {Atom("exact", f, place=0): poly(0) for f in FIELDS}
        stress = {Atom("exact", f): law for f, law in zip(STRESSES, self.stress_law, strict=True)}
        return p.rewrite(rules.get).rewrite(stress.get)

    def insert_waves(self, p: Poly) -> Poly:
        """Every field whose wave is known, as that wave."""

        def wave(a: Atom) -> Poly | None:
            if a.kind != "field" or (a.name, a.order) not in self.ansatz:
                return None
            value = self.ansatz[a.name, a.order]
            for variable, times in (("u", a.u), ("t", a.tau), ("T", a.slow)):
                for _ in range(times):
                    value = value.derive(variable)
            return value if a.place is None else value.at(a.place)

        return p.map(wave)

    def by_equations(self, p: Poly) -> Poly:
        """Modulo the balance laws, the equations of the modes, and the conditions at the ends."""
        return p.rewrite(lambda a: self._shape_meaning(a, self.shapes)).rewrite(self._rule)

    def by_lower_orders(self, p: Poly, n: int) -> Poly:
        """Modulo the conditions at the ends of orders below n."""
        return p.rewrite(
            lambda a: self._rule(a) if a.kind == "field" and a.order < n and a.place is not None else None
        )

    def _rule(self, a: Atom) -> Poly | None:
        if a.kind not in ("field", "shape"):
            return None
        plain = a.replace(bar=False)
        value = None
        if a.place is not None and plain.replace(tau=0, slow=0) in self._ends:
            value = self._ends[plain.replace(tau=0, slow=0)]
            for variable, times in (("t", a.tau), ("T", a.slow)):
                for _ in range(times):
                    value = value.derive(variable)
        elif a.u >= 2 and (a.kind, a.name, a.order) in self._tops:
            value = self._tops[a.kind, a.name, a.order]
            for variable, times in (("u", a.u - 2), ("t", a.tau), ("T", a.slow)):
                for _ in range(times):
                    value = value.derive(variable)
            value = value if a.place is None else value.at(a.place)
        return value.conjugate() if value is not None and a.bar else value

    def restored(self, p: Poly) -> Poly:
        """An expression in the letters in which the theory is written: H, P0, P2 for Y', X0', X2'."""
        shear = atom(Atom("shape", "H")) + constant("nu") * atom(Atom("shape", "Theta"))
        slopes = {"Y": shear}
        for name in ("X0", "X2"):
            tension = atom(Atom("shape", f"P{name[1]}")) - self.shapes[f"P{name[1]}"]
            slopes[name] = _solve(tension, Atom("shape", name, u=1)).map(
                lambda a: shear if a == Atom("shape", "Y", u=1) else None
            )

        def image(a: Atom) -> Poly | None:
            if a.kind != "shape" or a.name not in slopes or a.u != 1 or a.place is not None:
                return None
            return slopes[a.name].conjugate() if a.bar else slopes[a.name]

        return p.rewrite(image)

    def canonical(self, p: Poly, *, keep: frozenset[str] = frozenset()) -> Poly:
        """Constants by their definitions: nu, mu, the polar equations, R*^2; those in ``keep`` stay."""

        def image(a: Atom) -> Poly | None:
            if a == Atom("operator", "t"):
                return atom(a.replace(name="tau")) + constant("epsilon") ** 2 * atom(a.replace(name="T"))
            return self._constants.get(a.name) if a.kind == "constant" and a.name not in keep else None

        p = _reduced_power(p.rewrite(image), Atom("constant", "R_star"), self.saturated)
        return _reduced_power(p, Atom("exact", "cos"), 1 - atom(Atom("exact", "sin")) ** 2)

    def slow_equation(self, p: Poly) -> Poly:
        """dA/dT by the Stuart-Landau equation."""
        a, a_bar = atom(Atom("amplitude", "A")), atom(Atom("amplitude", "A", bar=True))
        rate = constant("alpha") * a**2 * a_bar + constant("beta") * constant("Delta") * a
        slow = Atom("amplitude", "A", slow=1)
        return p.map(
            lambda b: rate if b == slow else rate.conjugate() if b == slow.replace(bar=True) else None
        )


def _of_mode(a: Atom) -> Atom:
    """The shape in the place of a transverse field of order 1."""
    return Atom("shape", {"y": "Y", "theta": "Theta"}[a.name], u=a.u)


def _exact(p: Poly) -> Poly:
    """The quantities of a law as the exact ones."""
    names = (*STRAINS, *VELOCITIES, "cos", "sin", "theta")
    return p.map(lambda a: atom(Atom("exact", a.name)) if a.name in names else None)


def integral(p: Poly) -> Poly:
    """int_0^1 p du as a sum of constants times integrals of single products: linear, hence decidable."""
    total: list[tuple[Monomial, Any]] = []
    for m, c in p.terms.items():
        inside = frozenset(
            (a, e) for a, e in m if a == U or (a.kind in ("shape", "field", "exact") and a.place is None)
        )
        unit = Poly({inside: QQ_I.one})
        total += (Poly({m - inside: c}) * atom(Atom("integral", arg=unit))).terms.items()
    return Poly.of(total)


def normal_integrals(p: Poly) -> Poly:
    """Integrals whose integrands were rewritten, in their normal form again."""
    return p.map(lambda a: integral(a.arg) if a.kind == "integral" else None)


def _solve(row: Poly, top: Atom) -> Poly:
    """row = 0 for an atom that enters linearly with a constant coefficient."""
    coefficient = Poly.of((m - {(top, 1)}, c) for m, c in row.terms.items() if (top, 1) in m)
    rest = row - coefficient * atom(top)
    return -rest * coefficient.inverse()


def _root(p: Poly) -> Poly:
    return atom(Atom("sqrt", arg=p))


def _reduced_power(p: Poly, a: Atom, square: Poly) -> Poly:
    """Even powers of an atom whose square is known."""
    total = poly(0)
    for m, c in p.terms.items():
        power = dict(m).get(a, 0)
        half, rest = divmod(power, 2)
        head = m - {(a, power)} | ({(a, rest)} if rest else frozenset())
        total += Poly({frozenset(head): c}) * square**half
    return total


__all__ = ["Theory", "harmonic", "integral", "normal_integrals", "rational"]
