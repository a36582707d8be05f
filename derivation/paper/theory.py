"""The rules by which an expression is reduced, read off the derivation's records like the meanings."""

from __future__ import annotations

from functools import cached_property

from derivation.paper.algebra import (
    Atom,
    I,
    Poly,
    atom,
    constant,
    poly,
)
from derivation.paper.meanings import (
    FIELDS,
    ORDERS,
    STRAINS,
    STRESSES,
    VELOCITIES,
    Meanings,
    normal_integrals,
)
from derivation.paper.reasons import UndecidedError


class Theory(Meanings):
    """Meanings and rules, made once from a derivation."""

    @cached_property
    def eigenvalue_slope(self) -> str:
        """The name of d lambda/dF at the threshold: that of beta, which it is proved to be.

        lambda Gamma phi = M phi, differentiated in the force and projected on the adjoint mode, gives
        lambda' (Psi, phi)_Gamma = int Psi^dagger (M' - lambda Gamma') phi du + [Q(Psi, phi')]; at the tip the
        derivative of the mode obeys y' - nu theta = nu' Theta, so the end term is k2 Psi_Y(1)^* nu' Theta(1).
        These are the integrand and the end term that the expansion gives for the detuning.

        Raises:
            UndecidedError: if they are not, as with another tip load.
        """
        rate = I * constant("omega")
        bulk = poly(0)
        for k, (name, row) in enumerate(zip(("Y", "Theta"), self.d.adjoint.primal, strict=True), 1):
            slope = self.by_force(self.carried(row)) - rate * self.by_force(self.weights[k]) * atom(
                Atom("shape", name)
            )
            bulk += atom(Atom("shape", f"Psi_{name}", bar=True)) * slope
        theta, psi = atom(Atom("shape", "Theta", place=1)), atom(Atom("shape", "Psi_Y", bar=True, place=1))
        end = constant("k2") * psi * self.by_force(self.named("nu").at(1)) * theta
        kept = self.d.landau.detuning_kept
        for ours, theirs in ((bulk, kept.integrand), (end, kept.boundary)):
            if self.canonical(self.by_equations(ours - self.carried(theirs))):
                raise UndecidedError(f"{self.d.model.name}: d lambda/dF is not shown to be beta")
        return "beta"

    def by_force(self, p: Poly) -> Poly:
        """The derivative in the force of coefficients, nu and mu included."""
        return self.canonical(p).derive("force")

    @cached_property
    def _tops(self) -> dict[tuple[str, str, int], Poly]:
        """Second u-derivatives by the equations: of fields from the balance laws, of shapes from theirs."""
        rules: dict[tuple[str, str, int], Poly] = {}
        for n in ORDERS:
            for f, row in zip(FIELDS, self.d.hierarchy[n].balance, strict=True):
                rules["field", f, n] = _solve(self.carried(row), Atom("field", f, n, u=2))
        interior = self.d.adjoint.modes.interior | self.d.second.modes.interior
        for g, value in interior.items():
            (m,) = self.carried(g).terms
            ((a, _),) = m
            if a.u == 2 and not a.bar:
                rules["shape", a.name, 0] = self.carried(value).rewrite(
                    lambda b: self.shape_meaning(b, self.shapes)
                )
        return rules

    @cached_property
    def _ends(self) -> dict[Atom, Poly]:
        """Values at the ends: the rod's conditions order by order, those of the modes and corrections."""
        rules: dict[Atom, Poly] = {}
        for g, value in self.d.hierarchy.tip_rules.items():
            (m,) = self.carried(g).terms
            ((a, _),) = m
            rules[a.replace(place=1)] = self.carried(value).at(1)
            if a.order == 1 and a.name != "x":  # the mode obeys the conditions of order 1
                shape = Atom("shape", _MODE[a.name], u=a.u, place=1)
                rules[shape] = self.carried(value).map(_of_mode).at(1)
        for n in ORDERS:
            rules |= {Atom("field", f, n, place=0): poly(0) for f in FIELDS}
        for c in (self.d.second.mean, self.d.second.harmonic):
            name = f"X{c.harmonic}"
            drag = self.carried(c.tip_drag) * atom(Atom("shape", name))
            rules[Atom("shape", name, u=1, place=1)] = (self.carried(c.tip_slope) + drag).at(1)
            rules[Atom("shape", name, place=0)] = poly(0)
        rules |= {Atom("shape", s, place=0): poly(0) for s in ("Y", "Theta", "Psi_Y", "Psi_Theta")}
        rules[Atom("shape", "Y", place=1)] = poly(1)  # the normalisation
        for g, value in self.d.adjoint.modes.tip.items():
            (m,) = self.carried(g).terms
            ((a, _),) = m
            if a.name.startswith("Psi") and a.u and not a.bar:
                rules[a.replace(place=1)] = self.carried(value).at(1)
        return rules

    @cached_property
    def _constants(self) -> dict[str, Poly]:
        """nu and mu by the base state; the saturated amplitude and what follows from it."""
        amplitude, straight = self.d.amplitude, self.d.hierarchy.straight
        detuning = constant("epsilon") ** 2 * constant("Delta")
        slope = self.carried(amplitude.sigma[0]) * self.carried(amplitude.sigma[1]).inverse()
        delta = constant("Delta").inverse()
        return {
            **({"nu": self.carried(straight.nu)} if straight.nu is not None else {}),
            "mu": self.carried(straight.mu),
            "R_T": self.carried(amplitude.radial),
            "phase_T": self.carried(amplitude.phase),
            "T": constant("epsilon") ** 2 * constant("t"),
            "sigma": slope,
            "omega_branch": constant("omega") + slope * delta * detuning,
            "A_tip": 2 * _root(self.saturated * delta * detuning),
        }

    @cached_property
    def saturated(self) -> Poly:
        """R*^2."""
        return (
            self.carried(self.d.amplitude.saturated[0])
            * self.carried(self.d.amplitude.saturated[1]).inverse()
        )

    def by_exact_laws(self, p: Poly) -> Poly:
        """Modulo the balance laws (eq:dynamicsfull), the rod's conditions at its ends and its stress law."""

        def law(a: Atom) -> Poly | None:
            if a.kind == "exact" and a.place == 0 and a.name in _CLAMPED and not a.u:
                return poly(0 if a.tau else _CLAMPED[a.name])
            if a.name in STRESSES:
                k = STRESSES.index(a.name)
                if a == Atom("exact", a.name, u=1):
                    return self._turning[k] - self.body_force[k]
                if a == Atom("exact", a.name, place=1):
                    return self.tip_load[k]
            return self._tip_strains.get(a)

        stress = {Atom("exact", f): k for k, f in enumerate(STRESSES)}
        return p.rewrite(law).rewrite(lambda a: self.stress_law[stress[a]] if a in stress else None)

    @cached_property
    def _turning(self) -> tuple[Poly, ...]:
        """What the derivatives of the stresses along u are without loads."""
        h1, h2, bend, f1, f2, _ = (atom(Atom("exact", q)) for q in (*STRAINS, *STRESSES))
        return bend * f2, -bend * f1, h2 * f1 - h1 * f2

    @cached_property
    def _tip_strains(self) -> dict[Atom, Poly]:
        """Strains at the tip, where the stress law gives each by its own stress."""
        rules = {}
        for q, stress, load in zip(STRAINS, self._linear_law, self.tip_load, strict=True):
            if stress is not None:
                strain = Atom("exact", q, place=1)
                rules[strain] = _solve(stress.at(1) - load, strain)
        return rules

    @cached_property
    def _linear_law(self) -> list[Poly | None]:
        """The stress law, None where a stress is not linear in its strain alone."""
        laws: list[Poly | None] = []
        for q, stress in zip(STRAINS, self.stress_law, strict=True):
            strain = Atom("exact", q)
            alone = {a for a in stress.atoms if a.kind == "exact"} == {strain}
            laws.append(
                stress if alone and all(dict(m).get(strain, 0) in (0, 1) for m in stress.terms) else None
            )
        return laws

    def in_fields(self, p: Poly) -> Poly:
        """Exact quantities in x, y, theta and their derivatives along u: the strains by the kinematics,
        derivatives along t, but for those at the ends, by the balance laws, where the drag is linear in each
        velocity alone."""

        def image(a: Atom) -> Poly | None:
            if a.kind != "exact":
                return None
            if a.name in (*STRAINS, *VELOCITIES):
                return _along(self.kinematics(a.name), a, a.tau)
            if a.place == 0 and a.name in _CLAMPED and not a.u:
                return poly(0 if a.tau else _CLAMPED[a.name])
            if a.name in FIELDS and a.tau and a.place is None and self._rates:
                return _along(self._rates[a.name], a, a.tau - 1)
            return None

        return self.canonical(p.rewrite(image)) if p else p

    @cached_property
    def _rates(self) -> dict[str, Poly]:
        """dx/dt, dy/dt, dtheta/dt in the strains and the angle; empty where the drag is another.

        drag_k v_k = d(stress)/du - turning + load, dx/dt = v1 cos - v2 sin, dy/dt = v1 sin + v2 cos.
        """
        speeds = []
        for k, v in enumerate(VELOCITIES):
            coefficient = self.drag[k] * atom(Atom("exact", v)).inverse()
            if len(coefficient.terms) != 1 or any(a.kind == "exact" for a in coefficient.atoms):
                return {}
            load = self.body_force[k] + self.drag[k]
            slope = self.stress_law[k].derive("u")
            speeds.append((slope - self.by_exact_laws(self._turning[k]) + load) * coefficient.inverse())
        cos, sin = (atom(Atom("exact", f)) for f in ("cos", "sin"))
        v1, v2, spin = speeds
        return {"x": v1 * cos - v2 * sin, "y": v1 * sin + v2 * cos, "theta": spin}

    def insert_waves(self, p: Poly) -> Poly:
        """Every field whose wave is known, as that wave."""

        def wave(a: Atom) -> Poly | None:
            if a.kind != "field" or (a.name, a.order) not in self.ansatz:
                return None
            value = self.ansatz[a.name, a.order]
            for variable, times in (("u", a.u), ("tau", a.tau), ("T", a.slow)):
                for _ in range(times):
                    value = value.derive(variable)
            return value if a.place is None else value.at(a.place)

        return p.map(wave)

    def by_equations(self, p: Poly) -> Poly:
        """Modulo the balance laws, the equations of the modes, and the conditions at the ends."""
        atoms = {a for m in p.terms for a, _ in m}
        for a in atoms - self._solved.keys():
            value = atom(a).rewrite(lambda b: self.shape_meaning(b, self.shapes)).rewrite(self._rule)
            self._solved[a] = normal_integrals(value) if a.kind == "integral" else value
        return p.replaced({a: q for a in atoms if (q := self._solved[a]) != atom(a)})

    @cached_property
    def _solved(self) -> dict[Atom, Poly]:
        """Atoms modulo the equations, as they come up: the trials of a repair share most of theirs."""
        return {}

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
            for variable, times in (("tau", a.tau), ("T", a.slow)):
                for _ in range(times):
                    value = value.derive(variable)
        elif a.u >= 2 and (a.kind, a.name, a.order) in self._tops:
            value = self._tops[a.kind, a.name, a.order]
            for variable, times in (("u", a.u - 2), ("tau", a.tau), ("T", a.slow)):
                for _ in range(times):
                    value = value.derive(variable)
            value = value if a.place is None else value.at(a.place)
        return value.conjugate() if value is not None and a.bar else value

    def restored(self, p: Poly) -> Poly:
        """An expression in the letters in which the theory is written: H, P0, P2 for Y', X0', X2'."""
        shear = atom(Atom("shape", "H")) + self.named("nu") * atom(Atom("shape", "Theta"))
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

        p = without_powers(p.rewrite(image), Atom("constant", "R_star"), self.saturated)
        for a in {a for m in p.terms for a, _ in m}:
            if a.kind == "sqrt":
                p = without_powers(p, a, a.arg)
            elif a.kind == "exact" and a.name == "cos":
                p = without_powers(p, a, 1 - atom(a.replace(name="sin")) ** 2)
        return p

    def slow_equation(self, p: Poly) -> Poly:
        """dA/dT by the Stuart-Landau equation."""
        a, a_bar = atom(Atom("amplitude", "A")), atom(Atom("amplitude", "A", bar=True))
        rate = constant("alpha") * a**2 * a_bar + constant("beta") * constant("Delta") * a
        slow = Atom("amplitude", "A", slow=1)
        return p.map(
            lambda b: rate if b == slow else rate.conjugate() if b == slow.replace(bar=True) else None
        )


#: Values at the clamp, at all times.
_CLAMPED = {"x": 0, "y": 0, "theta": 0, "cos": 1, "sin": 0}
_MODE = {"y": "Y", "theta": "Theta"}


def _of_mode(a: Atom) -> Poly | None:
    """What stands for a transverse field of order 1 in the mode Y e^{i omega tau}."""
    if a.kind != "field":
        return None
    return (I * constant("omega")) ** a.tau * atom(Atom("shape", _MODE[a.name], u=a.u))


def _along(value: Poly, a: Atom, tau: int) -> Poly:
    """What stands for an exact quantity, differentiated as often as it is, at its place."""
    for variable, times in (("u", a.u), ("t", tau)):
        for _ in range(times):
            value = value.derive(variable)
    return value if a.place is None else value.at(a.place)


def _solve(row: Poly, top: Atom) -> Poly:
    """row = 0 for an atom that enters linearly with a constant coefficient."""
    coefficient = Poly.of((m - {(top, 1)}, c) for m, c in row.terms.items() if (top, 1) in m)
    rest = row - coefficient * atom(top)
    return -rest * coefficient.inverse()


def _root(p: Poly) -> Poly:
    return atom(Atom("sqrt", arg=p))


def without_powers(p: Poly, a: Atom, square: Poly) -> Poly:
    """Even powers of an atom whose square is known."""
    powers = {m: e for m in p.terms for b, e in m if b == a}
    total = p.keep(lambda m: m not in powers)
    for m, power in powers.items():
        half, rest = divmod(power, 2)
        head = m - {(a, power)} | ({(a, rest)} if rest else frozenset())
        total += Poly({frozenset(head): p.terms[m]}) * square**half
    return total
