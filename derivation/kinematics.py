"""Exact strains and velocities of a planar rod, and their expansions in epsilon.

The exact quantities are computed from the centreline r = (x, y) and the frame e1, e2 by the definitions
eq:definitions, in a ring where cos(theta) and sin(theta) are variables with d cos = -sin d theta and
d sin = cos d theta. The expansion maps that ring into power series whose coefficients live in the ring of
order-by-order jets.
"""

from __future__ import annotations

from dataclasses import dataclass

from sympy.polys.rings import PolyElement

from derivation.constitutive import Constitution
from derivation.jets import JetRing, from_expr, jet_ring
from derivation.symbols import FIELDS, jet_latex, jet_name, latex_of, register

#: eq:perturbationtheory: a quantity as its coefficients of epsilon^0 ... epsilon^N.
Series = tuple[PolyElement, ...]


@dataclass(frozen=True)
class ExactKinematics:
    """Strains (h1, h2, Pi) and velocities (v1, v2, Omega) as exact polynomials in ``ring``."""

    ring: JetRing
    strains: tuple[PolyElement, PolyElement, PolyElement]
    velocities: tuple[PolyElement, PolyElement, PolyElement]


@dataclass(frozen=True)
class ExpandedKinematics:
    """The same as series in epsilon, coefficients in the ring of jets (appendix A of the paper).

    ``theta`` is the angle itself, on which a tip load may depend.
    """

    ring: JetRing
    order: int
    theta: Series
    strains: tuple[Series, Series, Series]
    velocities: tuple[Series, Series, Series]


def exact_kinematics() -> ExactKinematics:
    """eq:definitions from r, e1 and e2."""
    ring = _exact_ring()
    cos, sin = ring["cos"], ring["sin"]
    r = (ring["x"], ring["y"])
    e1, e2 = (cos, sin), (-sin, cos)

    def along(name: str) -> tuple[PolyElement, PolyElement, PolyElement]:
        """(e1 . dr, e2 . dr, e2 . de1) for d = the derivation ``name``."""
        dr = tuple(ring.derive(c, name) for c in r)
        de1 = tuple(ring.derive(c, name) for c in e1)
        pairs = ((e1, dr), (e2, dr), (e2, de1))
        return tuple(ring.reduce(a[0] * b[0] + a[1] * b[1]) for a, b in pairs)

    return ExactKinematics(ring, along("u"), along("t"))


def _exact_ring() -> JetRing:
    jets = [f"{f}{s}" for f in FIELDS for s in ("", "_u", "_uu", "_t")]
    for f, tex in FIELDS.items():
        for suffix, op in (
            ("", ""),
            ("_u", r"\partial_u "),
            ("_uu", r"\partial_u^{2} "),
            ("_t", r"\partial_t "),
        ):
            register(f + suffix, op + tex)
    ring = jet_ring(
        ["cos", "sin", *jets],
        derivations={
            "u": {f"{f}{a}": b and f"{f}{b}" for f in FIELDS for a, b in
                  (("", "_u"), ("_u", "_uu"), ("_uu", None), ("_t", None))},
            "t": {f"{f}{a}": b and f"{f}{b}" for f in FIELDS for a, b in
                  (("", "_t"), ("_u", None), ("_uu", None), ("_t", None))},
        },
    )  # fmt: skip
    cos, sin = ring["cos"], ring["sin"]
    derivations = {
        name: {**ring.derivations[name], cos: -sin * rate, sin: cos * rate}
        for name, rate in (("u", ring["theta_u"]), ("t", ring["theta_t"]))
    }
    return JetRing(ring.ring, derivations, products=((sin**2, 1 - cos**2),))


def field_ring(order: int, law: Constitution) -> JetRing:
    """The ring of jets of x, y, theta at orders 1 ... ``order``; two times, tau and T.

    Where the straight rod is not uniform its stretch nu and the compression it carries depend on u.

    Raises:
        ValueError: if ``order`` is less than 1.
    """
    if order < 1:
        raise ValueError(f"order = {order}: the expansion starts at 1")
    # (u, tau, T) derivatives that the theory meets; T-derivatives of u-derivatives never occur.
    held = [(u, 0, 0) for u in range(4)] + [(0, 1, 0), (1, 1, 0), (0, 0, 1)]
    names: list[str] = []
    maps: dict[str, dict[str, str | None]] = {"u": {}, "tau": {}, "T": {}}
    for n in range(1, order + 1):
        for f in FIELDS:
            for jet in held:
                name = jet_name(f, n, *jet)
                names.append(name)
                register(name, jet_latex(f, n, *jet))
                for k, d in enumerate(("u", "tau", "T")):
                    shifted = tuple(e + (j == k) for j, e in enumerate(jet))
                    maps[d][name] = jet_name(f, n, *shifted) if shifted in held else None
    ring = jet_ring([*names, *parameter_names(law)], maps, inverses=law.inverses)
    return with_straight_rod(ring, law)


def parameter_names(law: Constitution) -> list[str]:
    """Every constant of the theory: the model's parameters and the letters of its straight rod."""
    for letter, inverse in law.inverses.items():
        register(inverse, f"{latex_of(letter)}^{{-1}}")
    own = ["k1", "k2", "gamma1", "gamma3", "force", "nu", "mu", *law.inverses.values(), "Delta"]
    extra = [*law.parameters[5:], *law.constants, *([] if law.uniform else ["load"])]
    return [*own, *extra]


def with_straight_rod(ring: JetRing, law: Constitution) -> JetRing:
    """Let nu and what depends on it, mu and the compression vary with u where a distributed load makes them.

    load' = b and nu' = -load'/K1 with b the tangential force per length (b < 0 compresses towards the clamp);
    mu = K2 nu + load, c(nu)' = c'(nu) nu' for a letter c and (1/c)' = -c'/c^2 for its inverse.
    """
    if law.uniform:
        return ring
    b = from_expr(law.body_load[0], ring)
    nu_u = ring.reduce(-b * from_expr(law.compliance[0], ring))
    images = {ring["load"]: b, ring["nu"]: nu_u}
    for name, slope in law.slopes.items():
        images[ring[name]] = None if slope is None else ring.reduce(from_expr(slope, ring) * nu_u)
    for letter, inverse in law.inverses.items():
        images[ring[inverse]] = -(ring[inverse] ** 2) * images.get(ring[letter], ring.zero)
    shear = from_expr(law.stiffness[1], ring)
    images[ring["mu"]] = images.get(shear, ring.zero) * ring["nu"] + shear * nu_u + b
    derivations = {name: dict(given) for name, given in ring.derivations.items()}
    derivations["u"] |= images
    return JetRing(ring.ring, derivations, ring.conjugates, ring.products)


def expand_kinematics(exact: ExactKinematics, law: Constitution, order: int) -> ExpandedKinematics:
    """Expand about x = nu u, y = theta = 0 through epsilon^order, for generic fields (appendix A).

    ``d/dt`` becomes ``d/dtau + epsilon^2 d/dT`` (eq:timederivative).
    """
    ring = field_ring(order, law)
    zero = ring.zero

    def field(f: str) -> Series:
        """Coefficients of the field itself; the base state nu u is carried by its u-derivative."""
        return (zero, *(ring[jet_name(f, n, 0)] for n in range(1, order + 1)))

    def d_u(s: Series, base: PolyElement) -> Series:
        return (base, *(ring.derive(c, "u") for c in s[1:]))

    def d_t(s: Series) -> Series:
        slow = (zero, zero, *(ring.derive(c, "T") for c in s[:-2]))
        return tuple(ring.derive(c, "tau") + t for c, t in zip(s, slow[: order + 1], strict=True))

    fields = {f: field(f) for f in FIELDS}
    straight = dict(zip(FIELDS, (ring["nu"], zero, zero), strict=True))
    slopes = {f: d_u(fields[f], straight[f]) for f in FIELDS}
    return insert_fields(exact, ring, fields["theta"], slopes, {f: d_t(s) for f, s in fields.items()})


def insert_fields(
    exact: ExactKinematics, ring: JetRing, theta: Series, slopes: dict[str, Series], rates: dict[str, Series]
) -> ExpandedKinematics:
    """The exact strains and velocities at fields given as series: theta, and d/du, d/dt of (x, y, theta)."""
    order = len(theta) - 1
    cos, sin = cosine_and_sine(ring, theta)
    images: dict[PolyElement, Series] = {exact.ring["cos"]: cos, exact.ring["sin"]: sin}
    images |= {exact.ring[f"{f}_u"]: s for f, s in slopes.items()}
    images |= {exact.ring[f"{f}_t"]: s for f, s in rates.items()}

    def expand(p: PolyElement) -> Series:
        return substitute(p, images, ring, order)

    h1, h2, curvature = map(expand, exact.strains)
    v1, v2, spin = map(expand, exact.velocities)
    return ExpandedKinematics(ring, order, theta, (h1, h2, curvature), (v1, v2, spin))


def cosine_and_sine(ring: JetRing, theta: Series) -> tuple[Series, Series]:
    """cos and sin of a series without constant term, from n c_n = -sum k theta_k s_{n-k} and its twin."""
    cos, sin = [ring.one], [ring.zero]
    for n in range(1, len(theta)):
        cos.append(-sum((k * theta[k] * sin[n - k] for k in range(1, n + 1)), ring.zero) / n)
        sin.append(sum((k * theta[k] * cos[n - k] for k in range(1, n + 1)), ring.zero) / n)
    return tuple(cos), tuple(sin)


def multiply(a: Series, b: Series, ring: JetRing) -> Series:
    """Truncated Cauchy product."""
    return tuple(sum((a[k] * b[n - k] for k in range(n + 1)), ring.zero) for n in range(len(a)))


def substitute(p: PolyElement, images: dict[PolyElement, Series], ring: JetRing, order: int) -> Series:
    """A polynomial of another ring at series: generators to ``images``, the others to their namesakes."""
    total = [ring.zero] * (order + 1)

    def constant(c: PolyElement) -> Series:
        return (c, *[ring.zero] * order)

    for monom, coeff in p.terms():
        term = constant(ring.ring.ground_new(coeff))
        for g, s, e in zip(p.ring.gens, p.ring.symbols, monom, strict=True):
            for _ in range(e):
                term = multiply(term, images[g] if g in images else constant(ring[s.name]), ring)
        total = [a + b for a, b in zip(total, term, strict=True)]
    return tuple(total)
