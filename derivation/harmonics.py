r"""The ansatz  xi^(1) = A (0, Y, Theta) e^{i omega tau} + c.c.  and harmonic bookkeeping.

After the ansatz every expression is a polynomial in the amplitude, its conjugate and shape functions of u;
the harmonic of a term is its degree in (A, dA/dT) minus its degree in their conjugates, so e^{i omega tau}
need not be written and d/dtau multiplies a term of harmonic m by i omega m.
"""

from __future__ import annotations

from dataclasses import dataclass

from sympy.polys.rings import PolyElement

from derivation.constitutive import Constitution
from derivation.hierarchy import Hierarchy
from derivation.jets import JetRing, from_expr, homomorphism, jet_ring
from derivation.kinematics import parameter_names, with_straight_rod
from derivation.symbols import BAR, FIELDS, SHAPES, TIP, register, shape_latex, symbol

_AMPLITUDES = ("A", "A_T")
#: Highest u-derivative held of each shape function.
_JETS = {"Theta": 3, "Y": 3, "H": 0, "X0": 2, "X2": 2, "P0": 1, "P2": 1, "Psi_Y": 3, "Psi_Theta": 3}
#: Shapes whose value (and that of their first derivative) at the tip is a constant of its own.
_TIPS = ("Theta", "Y", "Psi_Y", "Psi_Theta")


@dataclass(frozen=True)
class Modes:
    """The ring of modes, the images of the fields in it, and the rules of the first-order problem.

    Attributes:
        ring: polynomials in parameters, amplitudes and jets of the shape functions.
        fields: (field, order) -> its image; known so far.
        interior: highest derivatives of Y and Theta in terms of lower ones (the eigenvalue problem),
            with Y' = H + nu Theta, and the conjugates of these rules.
        tip, clamp: rules at u = 1 and u = 0.
    """

    ring: JetRing
    fields: dict[tuple[str, int], PolyElement]
    interior: dict[PolyElement, PolyElement]
    tip: dict[PolyElement, PolyElement]
    clamp: dict[PolyElement, PolyElement]

    @property
    def amplitudes(self) -> list[PolyElement]:
        return [self.ring[a + s] for s in ("", BAR) for a in _AMPLITUDES]

    def harmonic(self, monomial: PolyElement) -> int:
        """Multiple of e^{i omega tau} carried by a monomial."""
        plus = [self.ring[a] for a in _AMPLITUDES]
        minus = [self.ring[a + BAR] for a in _AMPLITUDES]
        return self.ring.degree(monomial, plus) - self.ring.degree(monomial, minus)

    def d_tau(self, p: PolyElement) -> PolyElement:
        """d/dtau: each term times i omega times its harmonic."""
        i_omega = self.ring.i * self.ring["omega"]
        return sum(
            (i_omega * self.harmonic(m) * m * c for m, c in self.ring.parts(p, self.amplitudes).items()),
            self.ring.zero,
        )

    def component(self, p: PolyElement, monomial: PolyElement) -> PolyElement:
        """Coefficient of a monomial in the amplitudes and the detuning, e.g. A**2 * A_bar or Delta * A."""
        return self.ring.coefficient(p, monomial, [*self.amplitudes, self.ring["Delta"]])

    def image(self, p: PolyElement) -> PolyElement:
        """An expression in the fields, with the ansatz substituted."""
        images = {}
        for g in _generators(p):
            jet = parse_jet(str(g))
            if jet:
                images[g] = self._jet(*jet)
        return self.ring.reduce(homomorphism(p, images, self.ring))

    def _jet(self, f: str, n: int, derivatives: str) -> PolyElement:
        """The image of a jet: u's differentiate, tau multiplies, T acts on the amplitude of order 1."""
        value = self.fields[f, n]
        for _ in range(derivatives.replace("tau", "").count("u")):
            value = self.ring.derive(value, "u")
        if "tau" in derivatives:
            value = self.d_tau(value)
        if "T" in derivatives:
            value = self.d_slow(value)
        return value

    def d_slow(self, p: PolyElement) -> PolyElement:
        """d/dT: the amplitude depends on the slow time, A -> dA/dT."""
        ring = self.ring
        return sum((p.diff(ring["A" + s]) * ring["A_T" + s] for s in ("", BAR)), ring.zero)

    def reduce(self, p: PolyElement) -> PolyElement:
        """Modulo the first-order (and known second-order) equations at an interior point."""
        return self.ring.rewrite(p, self.interior)

    def at_tip(self, p: PolyElement) -> PolyElement:
        """The value at u = 1, modulo the tip conditions."""
        return self.ring.rewrite(self.ring.rewrite(p, self.interior), self.tip)

    def at_clamp(self, p: PolyElement) -> PolyElement:
        """The value at u = 0, modulo the clamp."""
        return self.ring.rewrite(self.ring.rewrite(p, self.interior), self.clamp)

    def eigenoperator(self, linear: tuple[PolyElement, ...]) -> tuple[PolyElement, PolyElement]:
        """The rows of M applied to (Y, Theta), from the order-1 rows Gamma d_tau xi - M xi without drag."""
        still = {self.ring["omega"]: self.ring.zero}
        y, theta = (self.component(self.image(row), self.ring["A"]) for row in linear[1:])
        return -self.ring.apply(y, still), -self.ring.apply(theta, still)

    def longitudinal_rows(self, linear: PolyElement, tip: PolyElement) -> tuple[PolyElement, PolyElement]:
        """The row of M and the tip stress minus load for x = A X2 alone, with X2 as the name of the shape."""
        ring = self.ring
        wave = ring["A"] * ring["X2"] + ring["A" + BAR] * ring["X2" + BAR]
        alone = self.with_rules({("x", 1): wave}, {})
        row, tip_row = (alone.component(alone.image(p), ring["A"]) for p in (linear, tip))
        return -ring.apply(row, {ring["omega"]: ring.zero}), tip_row

    def with_rules(
        self,
        fields: dict[tuple[str, int], PolyElement],
        interior: dict[PolyElement, PolyElement],
    ) -> Modes:
        """The same with more fields known and more equations to reduce by (conjugates are added)."""
        rules = {**self.interior, **interior}
        rules.update(conjugate_rules(self.ring, interior))
        return Modes(self.ring, {**self.fields, **fields}, rules, self.tip, self.clamp)


def conjugate_rules(ring: JetRing, rules: dict[PolyElement, PolyElement]) -> dict[PolyElement, PolyElement]:
    """The conjugates of rewriting rules for single generators."""
    return {ring.conjugate(g): ring.conjugate(value) for g, value in rules.items()}


def mode_ring(law: Constitution) -> JetRing:
    """Parameters, amplitudes, jets of the shape functions and of their conjugates, tip values, u.

    Where K1 varies along the straight rod its position x has no closed form: x_F is dx/dF.
    """
    shapes = [(s, k) for k in range(4) for s in SHAPES if k <= _JETS[s]]
    # Low derivatives first, and Theta before Y before H: the order decides which factor of a product of a
    # mode and a conjugate mode carries the star when a real sum is written as "half + c.c.".
    rank = {"Theta": 0, "Y": 1, "H": 3}
    shapes.sort(key=lambda s: (5 if s[0] == "H" else 4 * s[1] + 2 * (s[1] > 0), rank.get(s[0], 4)))
    names, maps, bars = [], {}, {}
    for bar in ("", BAR):
        for s, k in shapes:
            name = _shape(s, k, bar)
            names.append(name)
            register(name, shape_latex(s, k, bool(bar)))
            maps[name] = _shape(s, k + 1, bar) if k < _JETS[s] else None
    tips = [_shape(s, 0, bar) + TIP for bar in ("", BAR) for s in _TIPS]
    for bar in ("", BAR):
        for s in _TIPS:
            register(_shape(s, 0, bar) + TIP, shape_latex(s, 0, bool(bar), tip=True))
    for s, k in shapes:
        bars[_shape(s, k)] = _shape(s, k, BAR)
    bars |= {s + TIP: s + BAR + TIP for s in _TIPS} | {a: a + BAR for a in _AMPLITUDES}
    register("A" + BAR, "A^*")
    register("A_T" + BAR, r"\frac{\mathrm{d}A^*}{\mathrm{d}T}")
    amplitudes = [a + s for a in _AMPLITUDES for s in ("", BAR)]
    ring = jet_ring(
        [
            *amplitudes,
            *names,
            *tips,
            "u",
            *parameter_names(law),
            "omega",
            "lam",
            *["x_F"] * law.stretch_varies,
        ],
        {"u": maps},
        bars,
        law.inverses,
    )
    ring = with_straight_rod(ring, law)
    derivation = dict(ring.derivations["u"])
    derivation[ring["u"]] = ring.one
    if law.stretch_varies:
        # K1 nu_F = -load_F with load = b (u - 1)
        b_force = from_expr(law.body_load[0].diff(symbol("force")), ring)
        register("x_F", r"\partial_{\mathcal{F}} x")
        derivation[ring["x_F"]] = b_force * (1 - ring["u"]) * from_expr(law.compliance[0], ring)
    for bar in ("", BAR):
        angle = ring[f"Theta{bar}"]
        nu_u = derivation.get(ring["nu"], ring.zero)
        derivation[ring[f"H{bar}"]] = ring[f"Y{bar}_uu"] - ring["nu"] * ring[f"Theta{bar}_u"] - nu_u * angle
    return JetRing(ring.ring, {"u": derivation}, ring.conjugates, ring.products)


def _shape(shape: str, u: int = 0, bar: str = "") -> str:
    return shape + bar + ("_" + "u" * u if u else "")


def first_order(hierarchy: Hierarchy) -> Modes:
    """Insert the ansatz eq:solutionlinear into order 1 and read off the eigenvalue problem."""
    ring = mode_ring(hierarchy.law)
    a, a_bar = ring["A"], ring["A" + BAR]
    zero = ring.zero

    def wave(shape: str) -> PolyElement:
        return a * ring[shape] + a_bar * ring[shape + BAR]

    fields = {("x", 1): zero, ("y", 1): wave("Y"), ("theta", 1): wave("Theta")}
    bare = Modes(ring, fields, {}, {}, {})
    order, straight = hierarchy[1], hierarchy.straight
    if any((*order.traction, *order.forcing)):
        raise ArithmeticError("the first-order problem is not homogeneous: the straight rod is wrong")
    # The equations give the highest derivatives; each enters its own row with minus its stiffness.
    rules = {}
    for shape, row, inverse in zip(("Y", "Theta"), order.linear[1:], straight.inverse[1:], strict=True):
        top = ring[f"{shape}_uu"]
        value = top + homomorphism(inverse, {}, ring) * bare.component(bare.image(row), a)
        rules[top] = ring.reduce(value)
        if any(str(g).endswith("_uu") for g in ring.generators_of(rules[top])):
            raise ArithmeticError(f"the first-order equations do not give {top}")
    rules[ring["Y_u"]] = ring["H"] + ring["nu"] * ring["Theta"]
    for shape in ("Y", "Theta"):
        rules[ring[f"{shape}_uuu"]] = ring.reduce(ring.derive(rules[ring[f"{shape}_uu"]], "u"))
    rules |= conjugate_rules(ring, rules)

    # u = 0: the clamp. u = 1: the tip conditions of order 1; Y(1) = 1 is not imposed.
    clamp = {ring["Y"]: zero, ring["Theta"]: zero, ring["u"]: zero}
    y_u, theta_u = (bare.component(bare.image(s), a) for s in order.slopes[1:])
    tip = {ring["H"]: y_u - ring["nu"] * ring["Theta"], ring["Theta_u"]: theta_u, ring["u"]: ring.one}
    tip |= {ring[s]: ring[s + TIP] for s in ("Y", "Theta")}
    clamp |= conjugate_rules(ring, clamp)
    tip |= conjugate_rules(ring, tip)
    return Modes(ring, fields, rules, tip, clamp)


def split_real(ring: JetRing, p: PolyElement) -> PolyElement:
    """A half h of a real expression, p = h + h*.

    Of a pair of conjugate terms the one is kept whose first factor, in the ring's order, is starred (a lone
    factor is kept without a star); self-conjugate terms are halved. That is a choice of notation: only
    h + h* enters the theory.

    Raises:
        ArithmeticError: if ``p`` is not real.
    """
    if ring.conjugate(p) != p:
        raise ArithmeticError(f"not real, so not of the form h + c.c.: {p}")
    half = ring.zero
    for monom, coeff in p.terms():
        term = ring.ring.from_dict({monom: coeff})
        if ring.conjugate(term).leading_expv() == monom:
            half += term / 2
        elif _kept(ring, monom):
            half += term
    return half


def _kept(ring: JetRing, monom: tuple[int, ...]) -> bool:
    index = {g: k for k, g in enumerate(ring.ring.gens)}
    factors = []  # (place of the unstarred twin, whether starred)
    for g, e in zip(ring.ring.gens, monom, strict=True):
        if e and g in ring.conjugates:
            twin = index[ring.conjugates[g]]
            factors.append((min(index[g], twin), index[g] > twin))
    starred = min(factors)[1]
    return starred if len(factors) > 1 else not starred


def _generators(p: PolyElement) -> list[PolyElement]:
    return [g for k, g in enumerate(p.ring.gens) if any(m[k] for m in p.monoms())]


def parse_jet(name: str) -> tuple[str, int, str] | None:
    """``theta1_uu`` -> ("theta", 1, "uu"); None for anything that is not a jet of a field."""
    head, _, derivatives = name.partition("_")
    f = head.rstrip("0123456789")
    if f in FIELDS and head != f:
        return f, int(head[len(f) :]), derivatives
    return None
