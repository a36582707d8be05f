r"""Modes as exponentials: exponents, amplitude ratios and boundary columns for any eigenvalue lambda.

The linear problem has constant coefficients, so Y = c e^{ru}, Theta = c rho e^{ru} with

    det [ M(r) - lambda Gamma ] = 0,    rho = Theta/Y  from its first row.

The adjoint operator is M again (only its boundary conditions differ), so rho serves for both, with lambda^*
for the adjoint. Four exponentials, four boundary conditions: a mode exists where the 4x4 determinant of the
boundary columns vanishes.
"""

from __future__ import annotations

from dataclasses import dataclass

from sympy.polys.rings import PolyElement

from derivation.adjoint import Adjoint
from derivation.hierarchy import Hierarchy
from derivation.jets import JetRing, homomorphism, jet_ring
from derivation.kinematics import parameter_names


@dataclass(frozen=True)
class Fraction:
    """numerator / denominator in the ring of exponents."""

    numerator: PolyElement
    denominator: PolyElement


@dataclass(frozen=True)
class Eigenproblem:
    """The characteristic problem of the straight rod.

    Attributes:
        ring: polynomials in r, exp_r, lam and the parameters.
        polynomial: (c4, c2, c0) of c4 r^4 + c2 r^2 + c0 = 0 for the exponents r.
        theta, shear: Theta/Y and H/Y of an exponential.
        column: contributions of an exponential to Y(0), Theta(0), H(1), Theta'(1).
        adjoint_column: the same for the adjoint conditions, with lam standing for lambda^*.
    """

    ring: JetRing
    polynomial: tuple[PolyElement, PolyElement, PolyElement]
    theta: Fraction
    shear: Fraction
    column: tuple[Fraction, ...]
    adjoint_column: tuple[Fraction, ...]


def eigenproblem(hierarchy: Hierarchy, adjoint: Adjoint) -> Eigenproblem:
    """Insert exponentials into the rows of M and into the boundary conditions.

    Raises:
        ArithmeticError: if M^dagger is not M, or if the characteristic polynomial is not even in r.
    """
    names = [n for n in parameter_names(hierarchy.law) if n not in ("Delta", "u")]
    ring = jet_ring(["r", "exp_r", "lam", *names], inverses=hierarchy.law.inverses)
    r, lam, e = ring["r"], ring["lam"], ring["exp_r"]
    unstarred = [adjoint.modes.ring.conjugate(row) for row in adjoint.operator]
    y_row, theta_row = (_symbol(row, ring, ("Y", "Theta"), lam) for row in adjoint.primal)
    if [_symbol(row, ring, ("Psi_Y", "Psi_Theta"), lam) for row in unstarred] != [y_row, theta_row]:
        raise ArithmeticError(
            "the operator is not formally self-adjoint; its adjoint needs its own exponents"
        )
    (yy, yt), (ty, tt) = y_row, theta_row
    straight = hierarchy.straight
    weights = [homomorphism(w, {}, ring) for w in straight.weights[1:]]
    letters = _Letters(
        ring, homomorphism(straight.stiffness[1], {}, ring), homomorphism(straight.load, {}, ring)
    )
    det = letters.shorten((yy - lam * weights[0]) * (tt - lam * weights[1]) - yt * ty)
    coefficients = {ring.degree(m, [r]): c for m, c in ring.parts(det, [r]).items()}
    if set(coefficients) != {0, 2, 4}:
        raise ArithmeticError(f"the characteristic polynomial is not even of degree 4 in r: {det}")

    # First row: (yy - lambda Gamma_2) Y + yt Theta = 0.
    theta = letters.cancel(-(yy - lam * weights[0]), yt)
    shear = letters.cancel(r * theta.denominator - ring["nu"] * theta.numerator, theta.denominator)
    one = Fraction(ring.one, ring.one)

    def at_tip(p: PolyElement, shapes: tuple[str, str], rate: PolyElement = lam) -> Fraction:
        a, b = _symbol(p, ring, shapes, rate)
        return letters.cancel(e * (a * theta.denominator + b * theta.numerator), theta.denominator)

    # Tip stresses divided by their stiffness: H(1) and Theta'(1) under the plain follower.
    inverses = [homomorphism(k, {}, adjoint.modes.ring) for k in straight.inverse[1:]]
    tip = [
        at_tip(adjoint.modes.ring.reduce(row * inverse), ("Y", "Theta"))
        for row, inverse in zip(adjoint.tip_stress, inverses, strict=True)
    ]
    return Eigenproblem(
        ring,
        (coefficients[4], coefficients[2], coefficients[0]),
        theta,
        shear,
        (one, theta, *tip),
        # a load with drag: where lam stands for lambda^*, i omega is -lam
        (one, theta, *(at_tip(p, ("Psi_Y", "Psi_Theta"), -lam) for p in adjoint.tip)),
    )


def _symbol(
    row: PolyElement, ring: JetRing, shapes: tuple[str, str], rate: PolyElement
) -> tuple[PolyElement, ...]:
    """The symbol of a row of a constant-coefficient operator: d/du becomes r, i omega becomes the rate."""
    jets = {s + ("_" + "u" * k if k else ""): (s, ring["r"] ** k) for s in shapes for k in range(3)}
    entries = []
    for s in shapes:
        images = {}
        for g, symbol in zip(row.ring.gens, row.ring.symbols, strict=True):
            if symbol.name == "omega":
                images[g] = -ring.i * rate
            elif symbol.name not in ring:
                owner, power = jets.get(symbol.name, ("", ring.zero))
                images[g] = power if owner == s else ring.zero
        entries.append(ring.reduce(homomorphism(row, images, ring)))
    return tuple(entries)


@dataclass(frozen=True)
class _Letters:
    """k2 nu written as mu - load: then mu^2 - k2 nu mu = mu load loses no digits when k2 is large."""

    ring: JetRing
    k2: PolyElement
    load: PolyElement

    def shorten(self, p: PolyElement) -> PolyElement:
        ring = self.ring
        known = JetRing(ring.ring, products=(*ring.products, (self.k2 * ring["nu"], ring["mu"] - self.load)))
        return known.reduce(p)

    def cancel(self, numerator: PolyElement, denominator: PolyElement) -> Fraction:
        """Cancel common factors; make the denominator positive."""
        numerator = self.shorten(numerator)
        if denominator.LC.x < 0:
            numerator, denominator = -numerator, -denominator
        common = numerator.gcd(denominator)
        return Fraction(numerator.exquo(common), denominator.exquo(common))
