"""α and β of a rod by an independent route: the discretised full rod, differentiated exactly.

Nothing of the expansion is used. The rod in its strains, E w_t = R(w, F) (`strainform`, where w now holds the
strains at the tip too), is linearised at the straight state; its critical eigenvectors and the exact second
and third derivatives of R give the coefficients of

    dA/dt = α |A|² A + β (F − F_c) A

by the textbook projection (Kuznetsov, Elements of Applied Bifurcation Theory, 3rd ed., section 5.4), here
with a constant singular E and a mode whose tip displacement is 1, so that the tip moves by 2 |A| cos.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from rodwnl.errors import ComputationError
from rodwnl.nilpotent import Nilpotent, Value, nilpotent
from rodwnl.strainform import RodLaw, Triple, integrals, mass, residual, tip

Vector = NDArray[Any]
MAX_STEPS = 50
SETTLED = 1e-8  # relative Newton step after which the error, its square, is below float64's round-off


@dataclass(frozen=True)
class NormalForm:
    """A Hopf point of the discretised rod; lengths in L, times in γ2 L⁴/k3, forces in k3/L².

    mode, adjoint (3(N+1) + 3,): right and left eigenvectors (slopes of h1, h2, Π at the nodes, then their
    values at the tip), tip displacement of the mode 1, adjoint*·E·mode = 1. residual: of the eigenproblem,
    relative to its largest row. tail: the mode's two last Chebyshev coefficients relative to its largest;
    where it is not small N is too low.
    """

    force: float
    omega: float
    alpha: complex
    beta: complex
    degree: int
    mode: Vector
    adjoint: Vector
    residual: float
    tail: float


def normal_form(law: RodLaw, force: float, omega: float, degree: int = 32) -> NormalForm:
    """The Hopf point nearest to this guess, and α and β there.

    Raises ComputationError where Newton's iteration does not arrive at a Hopf point.
    """
    rod = DiscreteRod(law, degree)
    force, omega, q, p = hopf_point(rod, force, omega)
    w, E = rod.straight(force), rod.mass
    L = rod.jacobian(w, force)

    def B(a: Vector, b: Vector) -> Vector:
        return rod.derivative(w, force, (a, 0.0), (b, 0.0))

    def C(a: Vector, b: Vector, c: Vector) -> Vector:
        return rod.derivative(w, force, (a, 0.0), (b, 0.0), (c, 0.0))

    # h11 = −L⁻¹ B(q, q̄),   h20 = (2iω E − L)⁻¹ B(q, q)
    h11 = -np.linalg.solve(L, B(q, q.conj()))
    h20 = np.linalg.solve(2j * omega * E - L, B(q, q))
    # α = ⟨p, ½ C(q, q, q̄) + B(q, h11) + ½ B(q̄, h20)⟩,   β = ⟨p, dL/dF q⟩,   ⟨p, E q⟩ = 1
    alpha = p.conj() @ (C(q, q, q.conj()) / 2 + B(q, h11) + B(q.conj(), h20) / 2)
    beta = p.conj() @ rod.along_force(w, force, q)
    defect = np.abs(L @ q - 1j * omega * (E @ q)).max() / (np.abs(L) @ np.abs(q)).max()
    return NormalForm(
        force, omega, complex(alpha), complex(beta), degree, q, p, float(defect), _tail(q, degree)
    )


@dataclass(frozen=True)
class DiscreteRod:
    """The law on one grid, the state strung into one vector: 3(N+1) slopes, then 3 strains at the tip."""

    law: RodLaw
    degree: int

    @property
    def size(self) -> int:
        return 3 * (self.degree + 1) + 3

    @cached_property
    def mass(self) -> Vector:
        """E: u z1_t − ∫₀ᵘ∫ᵤ¹ w_t in the rows of each field, nothing in those of the tip."""
        E, one = np.zeros((self.size, self.size)), np.eye(3)
        E[:-3, :-3] = np.kron(one, mass(self.degree))
        E[:-3, -3:] = np.kron(one, integrals(self.degree).nodes[:, None])
        return E

    def straight(self, force: float) -> Vector:
        """The straight state, R(w, F) = 0 with h2 = Π = 0, by Newton's method from the unloaded rod."""
        w = np.zeros(self.size)
        w[-3] = 1.0
        last = np.inf
        for _ in range(MAX_STEPS):
            R, L, _ = self.linearised(w, force)
            step = np.linalg.solve(L, R)
            w = w - step
            size = np.abs(step).max() / (1 + np.abs(w).max())
            if size <= 1e-15 or last / 4 < size < SETTLED:  # steps that cease to shrink are rounding
                return w
            last = size
        raise ComputationError(f"no straight equilibrium was found at force {force:.17g}")

    def derivative(self, w: Vector, force: float, *directions: tuple[Vector, float]) -> Vector:
        """D^k R(w, F) along k directions (dw, dF) of the shape of w and number; R itself for k = 0."""
        rows, shape = self._rows(w, force, *directions)
        return self._strung(rows, shape, *range(1, len(directions) + 1))

    def linearised(self, w: Vector, force: float) -> tuple[Vector, Vector, Vector]:
        """R, L = ∂R/∂w and ∂R/∂F at states w (…, size): (…, size), (…, size, size) and (…, size)."""
        directions = np.eye(self.size + 1, self.size), np.eye(1, self.size + 1, self.size).T
        rows, shape = self._rows(w[..., None, :], force, directions)
        slopes = self._strung(rows, shape, 1)
        R = self._strung(rows, (*shape[:-1], 1))[..., 0, :]
        return R, np.swapaxes(slopes[..., :-1, :], -2, -1), slopes[..., -1, :]

    def jacobian(self, w: Vector, force: float) -> Vector:
        """L = ∂R/∂w."""
        return self.linearised(w, force)[1]

    def _rows(
        self, w: Vector, force: float, *directions: tuple[Vector, Any]
    ) -> tuple[list[Nilpotent], tuple[int, ...]]:
        """R's rows for each field and end, with their derivatives along the directions; the leading shape."""
        states = nilpotent(w, *((i, d) for i, (d, _) in enumerate(directions, 1)))
        loads = nilpotent(force, *((i, d) for i, (_, d) in enumerate(directions, 1)))
        fields, ends = residual(self.law, *self.split(states), loads, self.degree)
        *many, _ = np.broadcast_shapes(w.shape, *(d.shape for d, _ in directions))
        return [*fields, *ends], tuple(many)

    def _strung(self, rows: list[Nilpotent], shape: tuple[int, ...], *directions: int) -> Vector:
        """Their coefficients of the product of these e_i, (*shape, size)."""
        widths = 3 * [self.degree + 1] + 3 * [1]
        parts = [row.part(*directions) for row in rows]
        return np.concatenate(
            [np.broadcast_to(part, (*shape, n)) for part, n in zip(parts, widths, strict=True)], axis=-1
        )

    def along_force(self, w: Vector, force: float, q: Vector) -> Vector:
        """dL/dF q while the straight state moves with the force: L s + ∂R/∂F = 0, D²R[(q, 0), (s, 1)]."""
        _, L, pull = self.linearised(w, force)
        shift = -np.linalg.solve(L, pull)
        return self.derivative(w, force, (q, 0.0), (shift, 1.0))

    def tip_row(self, w: Vector, force: float) -> Vector:
        """ℓ: slopes -> transverse displacement of the tip, linearised."""
        slopes = nilpotent(w, (1, np.eye(w.size)))
        row: Vector = tip(*self.split(slopes), self.degree)[1].part(1)
        return row

    def split(self, state: Nilpotent) -> tuple[Triple, Triple]:
        """The strains at the tip and the slopes."""
        n = self.degree + 1

        def columns(start: int, end: int) -> Value:
            return state.map(lambda a: a[..., start:end])

        return (
            (columns(3 * n, 3 * n + 1), columns(3 * n + 1, 3 * n + 2), columns(3 * n + 2, 3 * n + 3)),
            (columns(0, n), columns(n, 2 * n), columns(2 * n, 3 * n)),
        )


def hopf_point(rod: DiscreteRod, force: float, omega: float) -> tuple[float, float, Vector, Vector]:
    """(F, ω, q, p) with L(F) q = iω E q, p* L = iω p* E, ℓ q = 1, p* E q = 1.

    Newton's method on the scalar g(F, ω) of the bordered systems (Govaerts, Numerical Methods for
    Bifurcations of Dynamical Equilibria, 2000, chapter 3), which vanishes exactly where iω is an
    eigenvalue: (M b; ℓ 0)(q; g) = (0; 1) and (p* h)(M b; ℓ 0) = (0 1), M = L − iω E, so that dg = −p* dM q.
    """
    size = rod.size
    b = np.ones(size, dtype=complex)
    right, left = np.zeros(size + 1), np.zeros(size + 1)
    right[-1] = left[-1] = 1.0
    settled = False
    for _ in range(MAX_STEPS):
        w = rod.straight(force)
        M = rod.jacobian(w, force) - 1j * omega * rod.mass
        bordered = np.block([[M, b[:, None]], [rod.tip_row(w, force), np.zeros((1, 1))]])
        q, g = np.split(np.linalg.solve(bordered, right), [size])
        p = np.linalg.solve(bordered.conj().T, left)[:size]
        Eq = rod.mass @ q
        if settled:
            return float(force), float(omega), q, p / (p.conj() @ Eq).conj()
        # g = p* M_F q dF − i p* E q dω
        by_force, by_omega = p.conj() @ rod.along_force(w, force, q), -1j * (p.conj() @ Eq)
        columns = np.array([[by_force.real, by_omega.real], [by_force.imag, by_omega.imag]])
        if not np.isfinite(columns).all() or np.linalg.cond(columns) > 1e15:
            break
        d_force, d_omega = np.linalg.solve(columns, [g[0].real, g[0].imag])
        force, omega = force + d_force, omega + d_omega
        b = Eq / np.abs(Eq).max()
        settled = abs(d_force) <= SETTLED * abs(force) and abs(d_omega) <= SETTLED * abs(omega)
    raise ComputationError(
        f"no Hopf point found: the search stood at force {force:.6g}, frequency {omega:.6g} when it stopped; "
        "start it closer to the threshold"
    )


def _tail(q: Vector, degree: int) -> float:
    """The two last Chebyshev coefficients, relative to the field's largest; vanishing fields left out."""
    fields = q[:-3].reshape(3, degree + 1)
    mirrored = np.concatenate([fields, fields[:, -2:0:-1]], axis=1)
    series = np.abs(np.fft.fft(mirrored, axis=1)[:, : degree + 1])
    largest = series.max(axis=1)
    kept = largest > 1e-30 * largest.max()  # the stretch vanishes by symmetry
    return float((series[kept, -2:].max(axis=1) / largest[kept]).max())
