"""The same amplitude equation as other tools report it: factor, sign, and how they scale the critical vector.

With q = c (0, Y, Θ) instead of (0, Y, Θ) the state is x = w q + c.c., w = A/c, and

    dw/dt = (iω + β(F − F_c)) w + c1 w|w|²,    c1 = |c|² α.

Most tools take c so that the vector of nodal values has the 2-norm 1. Of a continuous rod that depends on
the mesh: it is defined here for N equal intervals, the values (x, y, θ) at u = 1/N, 2/N, …, 1. What does not
depend on c is β, Im α/Re α, the criticality and the slopes along the branch.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import mpmath as mp

from rodwnl.closedform import critical_mode, critical_state
from rodwnl.errors import InputError
from rodwnl.exact import ExactThreshold, MpNumbers
from rodwnl.fields import Field, Scalar
from rodwnl.parameters import RodParameters

MOST_INTERVALS = 1_000_000


@dataclass(frozen=True)
class Convention:
    """How a tool writes the coefficient.

    norm: of the vector that it takes as unit: "tip" (Y(1) = 1), "mesh" (2-norm of the nodal values),
    "weighted" (∫ γ1|x|² + |y|² + γ3|θ|² du). numbers: (β, c1, ω) -> what the tool prints, by its names.
    """

    equation: str
    norm: str
    numbers: Callable[[Scalar, Scalar, Scalar], dict[str, Scalar]]
    source: str


CONVENTIONS = {
    "paper": Convention(
        "dA/dt = alpha |A|^2 A + beta (F - F_c) A, Y(1) = 1",
        "tip",
        lambda beta, c1, omega: {"alpha": c1, "beta": beta},
        "the paper, eq:alphabetaformulas",
    ),
    "kuznetsov": Convention(
        "dw/dt = i omega w + c1 w|w|^2, l1 = Re c1/omega, <q, q> = 1",
        "mesh",
        lambda beta, c1, omega: {"l1": c1.real / omega, "c1": c1},
        "Kuznetsov, Elements of Applied Bifurcation Theory, section 5.4",
    ),
    "matcont": Convention(
        "l1 = Re c1 (omega times Kuznetsov's), <q, q> = 1",
        "mesh",
        lambda beta, c1, omega: {"l1": c1.real},
        "MatCont manual, Hopf point; Dhooge, Govaerts & Kuznetsov 2003, doi:10.1145/779359.779362",
    ),
    "bifurcationkit": Convention(
        "dz/dt = z (i omega + a (F - F_c) + b|z|^2), norm(zeta) = 1 (its default scale)",
        "mesh",
        lambda beta, c1, omega: {"a": beta, "b": c1},
        "BifurcationKit.jl manual, Simple Hopf point",
    ),
    "jaxcont": Convention(
        "l1 = Re c1/(2 omega) (half of the formula that it cites), q1.q1 + q2.q2 = 1",
        "mesh",
        lambda beta, c1, omega: {"l1": c1.real / (2 * omega)},
        "jaxcont 0.4.0, bifurcations/hopf_normal_form.py",
    ),
    "ff-bifbox": Convention(
        "dA/dt + alpha (F - F_c) A + beta A|A|^2 = 0, <q, M q> = 1 with M = diag(gamma1, 1, gamma3)",
        "weighted",
        lambda beta, c1, omega: {"alpha": -beta, "beta": -c1},
        "ff-bifbox, hopfcompute.edp with the signs of pull request 18 (April 2026)",
    ),
}


@dataclass(frozen=True)
class Converted:
    """The numbers of one threshold in a convention.

    norm: of (0, Y, Θ) with Y(1) = 1, so that a unit vector's tip value is 1/norm. mesh: the number of
    intervals, where it matters.
    """

    convention: str
    numbers: dict[str, Scalar]
    norm: Scalar
    mesh: int | None


def checked_mesh(name: str, mesh: str | None) -> int | None:
    """The number of intervals for a convention, or InputError: unknown name, mesh missing or out of place."""
    if name not in CONVENTIONS:
        raise InputError(f"there is no convention {name!r}; there are {', '.join(CONVENTIONS)}")
    if CONVENTIONS[name].norm != "mesh":
        if mesh is not None:
            raise InputError(f"the convention {name} does not depend on a mesh: leave out --mesh")
        return None
    if mesh is None:
        raise InputError(
            f"the convention {name} scales the vector of nodal values to length 1, which for a continuous "
            "rod depends on the mesh: give its number of intervals, for example --mesh 100"
        )
    if not (mesh.isascii() and mesh.isdigit() and 1 <= int(mesh[:9]) <= MOST_INTERVALS and len(mesh) < 9):
        raise InputError(f"mesh is {mesh!r}, but it must be a whole number from 1 to {MOST_INTERVALS}")
    return int(mesh)


def convert(rod: RodParameters, threshold: ExactThreshold, name: str, mesh: int | None = None) -> Converted:
    """What a tool would print for this threshold, to the threshold's digits."""
    convention = CONVENTIONS[name]
    with mp.workdps(threshold.working_digits):
        norm = _norm(rod, threshold, convention.norm, mesh)
        numbers = convention.numbers(threshold.beta, threshold.alpha / norm**2, threshold.omega)
    return Converted(name, numbers, norm, mesh)


def _norm(rod: RodParameters, threshold: ExactThreshold, kind: str, mesh: int | None) -> Scalar:
    """The norm of (0, Y, Θ) with Y(1) = 1."""
    if kind == "tip":
        return mp.mpf(1)
    state = critical_state(rod, threshold.force, threshold.omega, MpNumbers())
    mode = critical_mode(state)
    if kind == "weighted":
        given = mode.named()
        twice = given | {f"Psi_{name}": value for name, value in given.items()}
        square = state("norm_integrand", **twice).integral() + state("norm_boundary", **twice)
        return mp.sqrt(square.real)
    if mesh is None:
        raise InputError("this convention depends on the mesh: give the number of intervals")
    square = mode.Y * mode.Y.conjugate() + mode.Theta * mode.Theta.conjugate()
    return mp.sqrt(_nodal_sum(square, mesh).real)


def _nodal_sum(field: Field, intervals: int) -> Scalar:
    """Σ f(j/N), j = 1…N, of a sum of pure exponentials: geometric series."""
    total = mp.mpf(0)
    for key, (coefficient,) in field.terms.items():
        a = field.exponents.value(key)
        step = mp.expm1(a / intervals)
        total += coefficient * (mp.exp(a / intervals) * mp.expm1(a) / step if step else intervals)
    return total
