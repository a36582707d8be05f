r"""The normal form to any order: all harmonics, all responses, detuning in the coefficients.

Beyond order 3 one slow time does not suffice. Instead the motion is sought on the invariant manifold that
the critical mode spans, parametrised by the amplitude A and delta = force - critical force:

    (x, y, theta) = sum over p, q, r of  A^p A*^q delta^r Phi_pqr(u),
    dA/dt         = i omega A + sum over p = q + 1 of  c_pqr A^p A*^q delta^r.

A counts as epsilon and delta as epsilon^2, so a term has degree p + q + 2 r. Inserting gives for each
(p, q, r) a linear problem

    ((p - q) i omega Gamma - M) Phi = f - c_pqr Gamma Phi_100,      S Phi = t  at u = 1,

whose right-hand side holds terms of lower degree only. Where p = q + 1 the operator is singular and
Fredholm's condition gives c_pqr; the response Phi is then unique up to a multiple of the mode, which the
evaluation fixes by no tip displacement in Phi: then A is the tip's amplitude at the fundamental frequency.
c_210 = alpha and c_101 = beta.

At a steady crossing, lambda = 0, the amplitude a is real and there is no a*: the same series with q = 0, all
transverse problems are singular and da/dt = sum over odd p of c_p0r a^p delta^r, a pitchfork (no term of an
oscillation is a special case of it: the Hopf coefficients at omega = 0 would be wrong by a factor).

Cf. Kuznetsov, Elements of Applied Bifurcation Theory, sections 3.5 and 5.4 (homological equations).
"""

from __future__ import annotations

from dataclasses import dataclass

from sympy.polys.rings import PolyElement

from derivation.constitutive import Constitution
from derivation.hierarchy import balance_laws
from derivation.jets import JetRing, jet_ring
from derivation.kinematics import (
    ExactKinematics,
    Series,
    insert_fields,
    parameter_names,
    with_straight_rod,
)
from derivation.symbols import BAR, FIELDS, register

Index = tuple[int, int, int]
#: Letters of the shapes of x, y and theta.
_LETTERS = {"x": "X", "y": "Y", "theta": "Theta"}
_LATEX = {"X": "X", "Y": "Y", "Theta": r"\Theta"}
_PLACE = {f: k for k, f in enumerate(FIELDS)}
_SYMMETRIC = ("x",)
_ANTISYMMETRIC = ("y", "theta")


@dataclass(frozen=True)
class Response:
    """The problem of one Phi_pqr, p >= q; the rest are conjugates.

    Attributes:
        index: (p, q, r).
        fields: ("x",) where p + q is even, ("y", "theta") where it is odd, by reflection symmetry.
        forcing: f, a row for each field.
        traction: t, likewise.
        resonant: whether the operator is singular, so that there is a c_pqr.
        weight: the coefficient of -c_pqr in the rows and in t there: Gamma Phi_100 and what a load with drag
            adds; else zeros.
    """

    index: Index
    fields: tuple[str, ...]
    forcing: tuple[PolyElement, ...]
    traction: tuple[PolyElement, ...]
    resonant: bool
    weight: tuple[tuple[PolyElement, ...], tuple[PolyElement, ...]]

    @property
    def shapes(self) -> tuple[str, ...]:
        """Names of the shapes, one for each field."""
        return tuple(shape_name(f, self.index) for f in self.fields)

    @property
    def coefficient(self) -> str:
        """Name of c_pqr."""
        return coefficient_name(self.index)


@dataclass(frozen=True)
class NormalForm:
    """All responses of degree 2 ... order, in the order in which they can be solved."""

    ring: JetRing
    order: int
    steady: bool
    responses: tuple[Response, ...]


def shape_name(field: str, index: Index) -> str:
    """``Y210``; the critical mode itself is ``Y``, ``Theta``."""
    letter = _LETTERS[field]
    return letter if index == (1, 0, 0) else letter + "".join(map(str, index))


def coefficient_name(index: Index) -> str:
    """``c210`` for the coefficient of A^2 A* in dA/dt."""
    return "c" + "".join(map(str, index))


def _degree(index: Index) -> int:
    p, q, r = index
    return p + q + 2 * r


def indices(order: int, steady: bool = False) -> list[Index]:
    """All (p, q, r) with p >= q (q = 0 where it is steady) and degree 1 ... order, by degree."""
    found = [
        (p, q, r)
        for p in range(order + 1)
        for q in range(1 if steady else p + 1)
        for r in range(order + 1)
        if 1 <= p + q + 2 * r <= order
    ]
    return sorted(found, key=lambda i: (_degree(i), i))


def is_resonant(index: Index, steady: bool) -> bool:
    """Whether the problem of this response is singular."""
    p, q, _ = index
    return p % 2 == 1 if steady else p == q + 1


def require_order(order: int) -> None:
    """Raises ValueError for an order at which the amplitude equation gains no term."""
    if order < 3 or order % 2 == 0:
        raise ValueError(f"order = {order}: the amplitude equation gains terms at odd orders, 3, 5, 7, ...")


def expand_normal_form(
    exact: ExactKinematics, law: Constitution, order: int, steady: bool = False
) -> NormalForm:
    """Insert the ansatz into the exact rod and collect the problem of every response.

    Raises:
        ValueError: if ``order`` is even or less than 3: the amplitude equation gains terms at odd orders.
        ArithmeticError: if a problem holds unknowns that it should not.
    """
    require_order(order)
    every = indices(order, steady)
    ring = _ring(law, every, steady)
    fields = {f: _series(ring, f, every, order) for f in FIELDS}
    straight = dict(zip(FIELDS, (ring["nu"], ring.zero, ring.zero), strict=True))
    slopes = {f: (straight[f], *(ring.derive(c, "u") for c in s[1:])) for f, s in fields.items()}
    rate = _amplitude_rate(ring, every, order, steady)
    rates = {f: _d_t(ring, s, rate) for f, s in fields.items()}
    kinematics = insert_fields(exact, ring, fields["theta"], slopes, rates)
    _, _, balance, tip = balance_laws(law, kinematics)
    # At the highest degree only the resonant problems matter: they give the last coefficients.
    wanted = [i for i in every if i != (1, 0, 0) and (_degree(i) < order or is_resonant(i, steady))]
    responses = tuple(_response(ring, index, balance, tip, steady) for index in wanted)
    return NormalForm(ring, order, steady, responses)


def _ring(law: Constitution, every: list[Index], steady: bool) -> JetRing:
    names: list[str] = []
    maps: dict[str, str | None] = {}
    conjugates: dict[str, str] = {}
    for index in every:
        p, q, _ = index
        real = steady or p == q
        for f in _SYMMETRIC if (p + q) % 2 == 0 else _ANTISYMMETRIC:
            bars = ("",) if real else ("", BAR)
            for bar in bars:
                base = shape_name(f, index) + bar
                jets = [base, f"{base}_u", f"{base}_uu"]
                names += jets
                maps |= dict(zip(jets, [*jets[1:], None], strict=True))
                for k, name in enumerate(jets):
                    register(name, _latex(f, index, k, bool(bar)))
                    if not bar and not real:
                        conjugates[name] = (shape_name(f, index) + BAR) + ("_" + "u" * k if k else "")
        if is_resonant(index, steady) and index != (1, 0, 0):
            c = coefficient_name(index)
            names.append(c)
            register(c, f"c_{{{''.join(map(str, index))}}}")
            if not steady:
                names.append(c + BAR)
                conjugates[c] = c + BAR
                register(c + BAR, f"c_{{{''.join(map(str, index))}}}^*")
    if not steady:
        conjugates["A"] = "A" + BAR
    ring = jet_ring(
        ["A", "A" + BAR, *names, "u", *parameter_names(law), "omega", "lam"],
        {"u": maps},
        conjugates,
        law.inverses,
    )
    ring = with_straight_rod(ring, law)
    derivations = {"u": {**ring.derivations["u"], ring["u"]: ring.one}}
    return JetRing(ring.ring, derivations, ring.conjugates, ring.products)


def _latex(field: str, index: Index, u: int, bar: bool) -> str:
    letter = _LATEX[_LETTERS[field]]
    subscript = "" if index == (1, 0, 0) else f"_{{{''.join(map(str, index))}}}"
    return letter + subscript + "'" * u + ("^*" if bar else "")


def _monomial(ring: JetRing, index: Index) -> PolyElement:
    p, q, r = index
    return ring["A"] ** p * ring["A" + BAR] ** q * ring["Delta"] ** r


def _series(ring: JetRing, f: str, every: list[Index], order: int) -> Series:
    """sum A^p A*^q delta^r Phi_pqr, by degree; terms with p < q are conjugates of those with p > q."""
    parity = 0 if f in _SYMMETRIC else 1
    terms = [ring.zero] * (order + 1)
    for index in every:
        if (index[0] + index[1]) % 2 != parity:
            continue
        term = _monomial(ring, index) * ring[shape_name(f, index)]
        twin = ring.conjugate(term)
        terms[_degree(index)] += term if twin == term else term + twin
    return tuple(terms)


def _amplitude_rate(ring: JetRing, every: list[Index], order: int, steady: bool) -> Series:
    """dA/dt by degree."""
    terms = [ring.zero] * (order + 1)
    if not steady:
        terms[1] = ring.i * ring["omega"] * ring["A"]
    for index in every:
        if is_resonant(index, steady) and index != (1, 0, 0):
            terms[_degree(index)] += ring[coefficient_name(index)] * _monomial(ring, index)
    return tuple(terms)


def _d_t(ring: JetRing, s: Series, rate: Series) -> Series:
    """d/dt by the chain rule: ds/dA dA/dt + c.c., by degree."""
    total = [ring.zero] * len(s)
    a, a_bar = ring["A"], ring["A" + BAR]
    for m, term in enumerate(s):
        along, along_bar = term.diff(a), term.diff(a_bar)
        for k, speed in enumerate(rate):
            if speed and m - 1 + k < len(s) and m:
                total[m - 1 + k] += along * speed + along_bar * ring.conjugate(speed)
    return tuple(total)


def _response(
    ring: JetRing,
    index: Index,
    balance: tuple[Series, Series, Series],
    tip: tuple[Series, Series, Series],
    steady: bool,
) -> Response:
    """Collect A^p A*^q delta^r: what is linear in Phi_pqr stays on the left, the rest is forcing."""
    p, q, _ = index
    fields = _SYMMETRIC if (p + q) % 2 == 0 else _ANTISYMMETRIC
    own = [ring[shape_name(f, index) + d] for f in fields for d in ("", "_u", "_uu")]
    amplitudes = [ring["A"], ring["A" + BAR], ring["Delta"]]
    resonant = is_resonant(index, steady)
    slow = [ring[coefficient_name(index)]] if resonant else []
    found: list[list[PolyElement]] = []
    weights: list[list[PolyElement]] = []
    for rows in (balance, tip):
        forcing, weight = [], []
        for f in fields:
            row = ring.coefficient(rows[_PLACE[f]][_degree(index)], _monomial(ring, index), amplitudes)
            rest = ring.coefficient(row, ring.one, own)
            forcing.append(-ring.coefficient(rest, ring.one, slow))
            weight.append(rest.diff(slow[0]) if slow else ring.zero)
        found.append(forcing)
        weights.append(weight)
    for name in ring.names_of(sum(found[0] + found[1], ring.zero)):
        if name.startswith("c" + "".join(map(str, index))):
            raise ArithmeticError(f"{index}: the forcing holds its own coefficient {name}")
    return Response(
        index, fields, tuple(found[0]), tuple(found[1]), resonant, (tuple(weights[0]), tuple(weights[1]))
    )
