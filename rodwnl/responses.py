"""The amplitude equation beyond the cubic term, from the emitted responses of the rod.

    (x, y, θ) = Σ A^p A*^q δ^r Φ_pqr(u),    dA/dt = iωA + Σ_{p = q+1} c_pqr A^p A*^q δ^r,    δ = F − F_c

Each response solves a linear two-point problem with forcing f and traction t made of earlier ones,

    ((p − q) iω Γ − M) Φ + c_pqr Γ Φ_100 = f,    S Φ + c_pqr s = t at u = 1,    Φ(0) = 0,

with c_pqr = 0 unless p = q + 1. There the operator is singular, c_pqr is an unknown and the condition that
the tip does not move in Φ makes up for it (the gauge: A is the tip's amplitude at the fundamental
frequency). c_210 = α and c_101 = β come out without an adjoint, which checks the other route.

The unknowns are Φ'' at Gauss–Legendre nodes, so that nothing is differentiated. Lengths in L, times in
γ2 L⁴/k3, forces in k3/L². Y(1) = 1.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from rodwnl import kernels
from rodwnl.errors import ComputationError, InputError
from rodwnl.modes import critical_mode, nodes_at
from rodwnl.parameters import PLAIN, RodParameters, require_kind, require_rod
from rodwnl.quadrature import Nodes, gauss_legendre
from rodwnl.spectrum import HopfThreshold
from rodwnl.straightrod import StraightRod, arguments, straight_rod

Complex = NDArray[np.complex128]
Index = tuple[int, int, int]
Pool = dict[str, Any]

HIGHEST = 5  # what is emitted
LETTERS = {"alpha": "c210", "beta": "c101", "alpha1": "c211", "alpha5": "c320", "beta2": "c102"}
MORE_NODES = 16  # what the solution on `nodes_at` nodes is compared with


@dataclass(frozen=True)
class Fold:
    """Where the branch turns around by the amplitude equation of order 5: good near a Bautin point."""

    force: float
    A_tip: float


@dataclass(frozen=True)
class AmplitudeEquation:
    """dA/dt = (β1 δ + β2 δ²) A + (α + α' δ)|A|²A + α5 |A|⁴A at one threshold, and what follows from it.

    coefficients: c_pqr by name, c210 = α, c101 = β1, c102 = β2, c211 = α', c320 = α5; errors alike. α' and
    Im α5 depend on the gauge of Y210, Re α5 where Re α = 0 does not. third_harmonic: Y300(1), so that the tip
    moves by 2 Re(A e^{iωt} + third_harmonic A³ e^{3iωt} + …); None at order 3.
    A_tip2_slope, A_tip2_curvature, omega_slope, omega_curvature: A_tip² = slope δ + curvature δ² + …, ω − ω_c
    likewise, along the branch of limit cycles (curvatures: None at order 3); A_tip is half the peak-to-peak
    displacement of the tip. fold: None where the branch does not turn, and at order 3.
    """

    force: float
    omega: float
    coefficients: Mapping[str, complex]
    errors: Mapping[str, float]
    third_harmonic: complex | None
    A_tip2_slope: float
    A_tip2_curvature: float | None
    omega_slope: float
    omega_curvature: float | None
    A_tip2_curvature_error: float
    omega_curvature_error: float
    fold: Fold | None


def amplitude_equation(
    rod: RodParameters, threshold: HopfThreshold, order: int = HIGHEST
) -> AmplitudeEquation:
    """The coefficients through ``order`` (3 or 5) at a threshold of `hopf_thresholds`, of any rod.

    Errors are what more quadrature nodes change. Raises InputError for another order and at a steady
    crossing, and ComputationError where the modes are too steep for float64.
    """
    _require(rod, threshold)
    if order not in (3, HIGHEST):
        raise InputError(f"order {order}: the emitted modules hold the orders 3 and {HIGHEST}")
    if threshold.steady:
        raise InputError(
            f"at force = {threshold.force:.10g} the rod buckles: its amplitude is real, see `pitchfork`"
        )
    force, omega = threshold.force, threshold.omega
    solved, finer = (
        _responses(rod, force, omega, nodes).solve(order) for nodes in _two_grids(rod, force, omega)
    )
    best, other = (_equation(force, omega, s, order, {}) for s in (finer, solved))
    errors = {name: abs(c - other.coefficients[name]) for name, c in best.coefficients.items()}
    return _equation(
        force, omega, finer, order, errors,
        _change(best.A_tip2_curvature, other.A_tip2_curvature),
        _change(best.omega_curvature, other.omega_curvature),
    )  # fmt: skip


@dataclass(frozen=True)
class Pitchfork:
    """da/dt = β δ a + α a³ where a real eigenvalue passes through 0; a is the tip's displacement.

    y_tip2_slope: of the buckled state's squared tip displacement in the force, −β/α. *_error: estimates.
    """

    force: float
    alpha: float
    beta: float
    y_tip2_slope: float
    alpha_error: float
    beta_error: float

    @property
    def y_tip2_slope_error(self) -> float:
        """From those of α and β."""
        return abs(self.y_tip2_slope) * (
            self.alpha_error / abs(self.alpha) + self.beta_error / abs(self.beta)
        )

    @property
    def criticality(self) -> Literal["supercritical", "subcritical", "degenerate"]:
        """By the sign of α; degenerate where the error does not exclude 0."""
        if abs(self.alpha) <= self.alpha_error:
            return "degenerate"
        return "supercritical" if self.alpha < 0 else "subcritical"


def pitchfork(rod: RodParameters, threshold: HopfThreshold) -> Pitchfork:
    """The amplitude equation at a steady crossing. Raises InputError where the threshold is oscillatory."""
    _require(rod, threshold)
    if not threshold.steady:
        raise InputError(f"at force = {threshold.force:.10g} the rod oscillates: see `amplitude_equation`")
    coarse, fine = (
        _responses(rod, threshold.force, 0.0, nodes).solve(3).coefficients
        for nodes in _two_grids(rod, threshold.force, 0.0)
    )
    alpha, beta = fine["c300"].real, fine["c101"].real
    return Pitchfork(
        threshold.force, alpha, beta, -beta / alpha,
        abs(fine["c300"] - coarse["c300"]), abs(fine["c101"] - coarse["c101"]),
    )  # fmt: skip


def _require(rod: RodParameters, threshold: HopfThreshold) -> None:
    require_rod(rod)
    require_kind("threshold", threshold, HopfThreshold, "one of those that `hopf_thresholds` finds")


def _two_grids(rod: RodParameters, force: float, omega: float) -> tuple[Nodes, Nodes]:
    count = len(nodes_of(rod, force, omega).u)
    return gauss_legendre(count), gauss_legendre(count + MORE_NODES)


def nodes_of(rod: RodParameters, force: float, omega: float) -> Nodes:
    """Nodes that resolve products of the modes."""
    if rod.model == PLAIN:
        return nodes_at(rod.floats(), force, omega)
    from rodwnl import thresholds

    return thresholds.nodes_at(rod, force, omega)


def _equation(
    force: float,
    omega: float,
    solved: _Solved,
    order: int,
    errors: Mapping[str, float],
    amplitude_error: float = 0.0,
    frequency_error: float = 0.0,
) -> AmplitudeEquation:
    """What the amplitude equation says of the branch of limit cycles."""
    predicted = derived_from(solved.coefficients, solved.third_harmonic)

    def curvature(name: str) -> float | None:
        return float(predicted(name)) if order > 3 else None

    return AmplitudeEquation(
        force, omega, solved.coefficients, errors, solved.third_harmonic,
        float(predicted("tip_amplitude_squared_slope")), curvature("tip_amplitude_squared_curvature"),
        float(predicted("frequency_slope")), curvature("frequency_curvature"),
        amplitude_error, frequency_error, _fold(force, solved) if order > 3 else None,
    )  # fmt: skip


def _fold(force: float, solved: _Solved) -> Fold | None:
    """The root of the fold's quadratic that tends to 0 with Re α, if R² > 0 there."""
    predicted = derived_from(solved.coefficients, solved.third_harmonic)
    c2, c1, c0 = predicted("fold_polynomial")
    discriminant = c1**2 - 4 * c2 * c0
    if discriminant < 0 or solved.third_harmonic is None:
        return None
    detuning = -2 * c0 / (c1 + np.copysign(np.sqrt(discriminant), c1))
    squared = predicted("fold_modulus_squared", detuning=detuning)
    if not squared > 0:
        return None
    R = np.sqrt(squared)
    # The tip is farthest out at phase 0 to this order: 2R + 2 Re Y300(1) R³.
    return Fold(float(force + detuning), float(2 * R + 2 * solved.third_harmonic.real * R**3))


def derived_from(coefficients: Mapping[str, Any], third_harmonic: Any) -> Callable[..., Any]:
    """The emitted predictions by name, at these coefficients, in whichever numbers they are."""
    parts: Pool = {} if third_harmonic is None else {"third_re": third_harmonic.real}
    for name, symbol in LETTERS.items():
        if symbol in coefficients:
            c = coefficients[symbol]
            parts |= {f"{name}_re": c.real, f"{name}_im": c.imag}

    def predicted(name: str, **more: Any) -> Any:
        f: Callable[..., Any] = getattr(kernels, name)
        known = {**parts, **more}
        return f(*(known[a] for a in arguments(f)))

    return predicted


def _change(a: float | None, b: float | None) -> float:
    return 0.0 if a is None or b is None else abs(a - b)


def terms(order: int, steady: bool = False) -> list[Index]:
    """(p, q, r), p >= q, of the responses through ``order``, in the order in which they can be solved."""
    found = [
        (p, q, r)
        for p in range(order + 1)
        for q in range(1 if steady else p + 1)
        for r in range(order + 1)
        if 2 <= p + q + 2 * r < order or (p + q + 2 * r == order and is_resonant((p, q, r), steady))
    ]
    return sorted(found, key=lambda i: (i[0] + i[1] + 2 * i[2], i))


def is_resonant(index: Index, steady: bool = False) -> bool:
    """Whether a response has a coefficient of the amplitude equation as another unknown."""
    p, q, _ = index
    return p % 2 == 1 if steady else p == q + 1


@dataclass(frozen=True)
class _Solved:
    coefficients: dict[str, complex]
    third_harmonic: complex | None


class Responses:
    """Solves response after response; what is known is kept by name, at the nodes and at the tip.

    straight: the rod at the threshold. mode: Y, Y_u, Theta, Theta_u at the nodes, Theta at the tip; Y(1) = 1.
    """

    def __init__(
        self, straight: StraightRod, omega: float, nodes: Nodes, mode: Pool, Theta_tip: complex
    ) -> None:
        self.straight, self.nodes = straight, nodes
        self.lam, self.steady = 1j * omega, omega == 0
        self.twice = nodes.from_clamp @ nodes.from_clamp  # Φ'' -> Φ − Φ'(0) u
        self.at_nodes: Pool = {"u": nodes.u, "lam": self.lam, **mode}
        self.at_tip: Pool = {"u": 1.0, "lam": self.lam, **self._tip_of_mode(Theta_tip)}
        self.drag: tuple[Any, Any, Any] = straight("drag_weights", **self.at_nodes)
        for name, row, weight in zip(("Y", "Theta"), ("y_row", "theta_row"), self.drag[1:], strict=True):
            # λΓ(Y, Θ) = M(Y, Θ) gives the second derivative.
            y, y_u, y_uu, t, t_u, t_uu = straight(row, **self.at_nodes)
            rest = y * mode["Y"] + y_u * mode["Y_u"] + t * mode["Theta"] + t_u * mode["Theta_u"]
            self.at_nodes[f"{name}_uu"] = (self.lam * weight * mode[name] - rest) / (y_uu + t_uu)

    def _tip_of_mode(self, Theta_tip: complex) -> Pool:
        """Y'(1) and Θ'(1) from the tip conditions."""
        rows = np.array([self.straight(f"{n}_tip_row", u=1.0, lam=self.lam) for n in ("y", "theta")])
        Y_u, Theta_u = np.linalg.solve(rows[:, [1, 3]], -rows[:, 0] - rows[:, 2] * Theta_tip)
        return {"Y": 1.0, "Y_u": Y_u, "Theta": Theta_tip, "Theta_u": Theta_u}

    def solve(self, order: int, gauge: Mapping[Index, complex] | None = None) -> _Solved:
        """All responses through ``order``; gauge: tip displacement of resonant ones, where it is not 0."""
        coefficients = {}
        prefix = "steady_" if self.steady else ""
        for index in terms(order, self.steady):
            p, q, _ = index
            digits = "".join(map(str, index))
            names = (f"Y{digits}", f"Theta{digits}") if (p + q) % 2 else (f"X{digits}",)
            forcing = _tuple(self.straight(f"{prefix}{names[0]}_forcing", **self.at_nodes))
            traction = _tuple(self.straight(f"{prefix}{names[0]}_traction", **self.at_tip))
            right = np.concatenate([*(np.broadcast_to(f, self.nodes.u.shape) for f in forcing), traction])
            lam = (p - q) * self.lam
            if is_resonant(index, self.steady):
                solution, c = self._resonant(lam, right, (gauge or {}).get(index, 0.0))
                name = f"c{digits}"
                coefficients[name] = self.at_nodes[name] = self.at_tip[name] = c
            else:
                matrix = self._transverse(lam) if len(names) == 2 else self._longitudinal(lam)
                solution = _solve(matrix, right)
            self._keep(solution, names)
        third_harmonic = complex(self.at_tip["Y300"]) if "Y300" in self.at_tip else None
        return _Solved(coefficients, third_harmonic)

    def _longitudinal(self, lam: complex) -> Complex:
        """λΓ − M and S on X: unknowns X'' at the nodes and X'(0)."""
        row = self.straight("x_row", u=self.nodes.u)
        return self._block(row, self.straight("x_tip_row", u=1.0, lam=lam), lam * self.drag[0])

    def _transverse(self, lam: complex) -> Complex:
        """λΓ − M and S on (Y, Θ): unknowns Y'', Y'(0), Θ'', Θ'(0)."""
        n = len(self.nodes.u)
        interior, edges = [], []
        for k, name in enumerate(("y", "theta")):
            row = self.straight(f"{name}_row", u=self.nodes.u)
            tip = self.straight(f"{name}_tip_row", u=1.0, lam=lam)
            blocks = [
                self._block(row[3 * j : 3 * j + 3], tip[2 * j : 2 * j + 2], lam * self.drag[k + 1] * (j == k))
                for j in range(2)
            ]
            whole = np.hstack(blocks)
            interior.append(whole[:n])
            edges.append(whole[n:])
        return np.vstack([*interior, *edges])

    def _resonant(self, lam: complex, right: Complex, gauge: complex) -> tuple[Complex, complex]:
        """(λΓ − M) Φ + cΓ Φ_100 = f with Φ_Y(1) = gauge: Φ and c."""
        n = len(self.nodes.u)
        column = np.concatenate(
            [
                *(w * self.at_nodes[s] for w, s in zip(self.drag[1:], ("Y", "Theta"), strict=True)),
                self._tip_drag(),
            ]
        )
        displacement = np.concatenate([self._tip_value(), np.zeros(n + 1)])
        bordered = np.block(
            [[self._transverse(lam), column[:, None]], [displacement[None, :], np.zeros((1, 1))]]
        )
        solution = _solve(bordered, np.append(right, gauge))
        return solution[:-1], complex(solution[-1])

    def _tip_drag(self) -> Complex:
        """What a load with drag adds where dA/dt acts: the part of S proportional to λ, on the mode."""
        mode = np.array([self.at_tip[s] for s in ("Y", "Y_u", "Theta", "Theta_u")])
        rows = [
            [np.array(self.straight(f"{name}_tip_row", u=1.0, lam=lam)) for lam in (0.0, 1.0)]
            for name in ("y", "theta")
        ]
        return np.array([(one - none) @ mode for none, one in rows])

    def _tip_value(self) -> NDArray[np.float64]:
        """Φ(1) from (Φ'', Φ'(0))."""
        return np.append(self.nodes.weights @ self.nodes.from_clamp, 1.0)

    def _block(self, row: Any, tip: Any, drag: Any) -> Complex:
        """drag Φ − row·(Φ, Φ', Φ'') at the nodes and tip·(Φ, Φ') at u = 1, from (Φ'', Φ'(0))."""
        n, nodes = len(self.nodes.u), self.nodes
        by_value = np.hstack([self.twice, nodes.u[:, None]])
        by_slope = np.hstack([nodes.from_clamp, np.ones((n, 1))])
        by_top = np.hstack([np.eye(n), np.zeros((n, 1))])
        value, slope, top = (np.broadcast_to(c, (n,))[:, None] for c in (drag - row[0], *row[1:]))
        interior = value * by_value - slope * by_slope - top * by_top
        edge = tip[0] * self._tip_value() + tip[1] * np.append(nodes.weights, 1.0)
        return np.vstack([interior, edge[None, :]])

    def _keep(self, solution: Complex, names: tuple[str, ...]) -> None:
        """Φ, Φ', Φ'' at the nodes and Φ, Φ' at the tip under their names."""
        for name, part in zip(names, np.split(solution, len(names)), strict=True):
            w, slope = part[:-1], part[-1]
            self.at_nodes[name] = self.twice @ w + slope * self.nodes.u
            self.at_nodes[f"{name}_u"] = self.nodes.from_clamp @ w + slope
            self.at_nodes[f"{name}_uu"] = w
            self.at_tip[name] = self._tip_value() @ part
            self.at_tip[f"{name}_u"] = slope + self.nodes.weights @ w


def _responses(rod: RodParameters, force: float, omega: float, nodes: Nodes) -> Responses:
    """The critical mode in exponentials where it is known in them, else by spectral integration."""
    straight = straight_rod(rod, force)
    if rod.model == PLAIN:
        mode: Any = critical_mode(rod.floats(), force, omega, nodes)
    else:
        from rodwnl import expansion

        mode = expansion.critical_mode(straight, omega, nodes)
    nu, _ = straight.stretch(nodes.u)
    here = {"Y": mode.Y, "Y_u": mode.H + nu * mode.Theta, "Theta": mode.Theta, "Theta_u": mode.Theta_u}
    return Responses(straight, omega, nodes, here, mode.Theta_tip)


def _tuple(value: Any) -> tuple[Any, ...]:
    return value if isinstance(value, tuple) else (value,)


def _solve(matrix: Complex, right: Complex) -> Complex:
    scale = np.max(np.abs(matrix), axis=1)
    try:
        return np.asarray(np.linalg.solve(matrix / scale[:, None], right / scale))
    except np.linalg.LinAlgError:
        raise ComputationError(
            "a multiple of the critical frequency is an eigenvalue too: the expansion has no such term"
        ) from None
