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
from derivation.jets import Images, JetRing, homomorphism, jet_ring

_PARAMETERS = ("k1", "k2", "gamma1", "gamma3", "force", "nu", "mu")


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


def eigenproblem(adjoint: Adjoint) -> Eigenproblem:
    """Insert exponentials into the rows of M and into the boundary conditions.

    Raises:
        ArithmeticError: if M^dagger is not M, or if the characteristic polynomial is not even in r.
    """
    ring = jet_ring(["r", "exp_r", "lam", *_PARAMETERS])
    r, lam = ring["r"], ring["lam"]
    unstarred = [adjoint.modes.ring.conjugate(row) for row in adjoint.operator]
    y_row, theta_row = (_symbol(row, ring, ("Y", "Theta")) for row in adjoint.primal)
    if [_symbol(row, ring, ("Psi_Y", "Psi_Theta")) for row in unstarred] != [y_row, theta_row]:
        raise ArithmeticError(
            "the operator is not formally self-adjoint; its adjoint needs its own exponents"
        )
    (yy, yt), (ty, tt) = y_row, theta_row
    det = (yy - lam) * (tt - lam * ring["gamma3"]) - yt * ty
    # k2 nu is mu - force: written so, mu^2 - k2 nu mu = mu force loses no digits when k2 is large.
    det = _rewrite_k2_nu(ring, det)
    coefficients = {ring.degree(m, [r]): c for m, c in ring.parts(det, [r]).items()}
    if set(coefficients) != {0, 2, 4}:
        raise ArithmeticError(f"the characteristic polynomial is not even of degree 4 in r: {det}")

    # First row: (yy - lambda) Y + yt Theta = 0.
    theta = _cancel(ring, -(yy - lam), yt)
    shear = _cancel(ring, r * theta.denominator - ring["nu"] * theta.numerator, theta.denominator)
    one = Fraction(ring.one, ring.one)
    e = ring["exp_r"]

    def at_tip(p: PolyElement) -> Fraction:
        a, b = _symbol(p, ring, ("Psi_Y", "Psi_Theta"))
        return _cancel(ring, e * (a * theta.denominator + b * theta.numerator), theta.denominator)

    tip = (
        _cancel(ring, e * shear.numerator, shear.denominator),
        _cancel(ring, e * r * theta.numerator, theta.denominator),
    )
    return Eigenproblem(
        ring,
        (coefficients[4], coefficients[2], coefficients[0]),
        theta,
        shear,
        (one, theta, *tip),
        (one, theta, *(at_tip(p) for p in adjoint.tip)),
    )


def _symbol(row: PolyElement, ring: JetRing, shapes: tuple[str, str]) -> tuple[PolyElement, ...]:
    """The symbol of a row of a constant-coefficient operator: d/du becomes r."""
    images: Images = {g: ring.zero for g in row.ring.gens if str(g) not in ring}
    entries = []
    for s in shapes:
        one = {
            **images,
            **{
                g: ring["r"] ** k
                for k in range(3)
                for g in row.ring.gens
                if str(g) == s + ("_" + "u" * k if k else "")
            },
        }
        entries.append(homomorphism(row, one, ring))
    return tuple(entries)


def _rewrite_k2_nu(ring: JetRing, p: PolyElement) -> PolyElement:
    k2, nu = ring["k2"], ring["nu"]
    known = JetRing(ring.ring, products=((k2 * nu, ring["mu"] - ring["force"]),))
    return known.reduce(p)


def _cancel(ring: JetRing, numerator: PolyElement, denominator: PolyElement) -> Fraction:
    """Cancel common powers of r after writing k2 nu as mu - force; make the denominator positive."""
    numerator = _rewrite_k2_nu(ring, numerator)
    if denominator.LC.x < 0:
        numerator, denominator = -numerator, -denominator
    common = numerator.gcd(denominator)
    return Fraction(numerator.exquo(common), denominator.exquo(common))
