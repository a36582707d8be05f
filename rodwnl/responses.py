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
from typing import Any

import numpy as np
from numpy.typing import NDArray

from rodwnl import kernels
from rodwnl.coefficients import LandauCoefficients
from rodwnl.errors import ComputationError, InputError
from rodwnl.modes import critical_mode, nodes_at
from rodwnl.parameters import RodParameters
from rodwnl.quadrature import Nodes, gauss_legendre

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
    moves by 2 Re(A e^{iωt} + third_harmonic A³ e^{3iωt} + …).
    A_tip2_slope, A_tip2_curvature, omega_slope, omega_curvature: A_tip² = slope δ + curvature δ² + …, ω − ω_c
    likewise, along the branch of limit cycles (curvatures: None at order 3); A_tip is half the peak-to-peak
    displacement of the tip. fold: None where the branch does not turn, and at order 3.
    """

    force: float
    omega: float
    coefficients: Mapping[str, complex]
    errors: Mapping[str, float]
    third_harmonic: complex
    A_tip2_slope: float
    A_tip2_curvature: float | None
    omega_slope: float
    omega_curvature: float | None
    A_tip2_curvature_error: float
    omega_curvature_error: float
    fold: Fold | None


def amplitude_equation(
    rod: RodParameters, threshold: LandauCoefficients, order: int = HIGHEST
) -> AmplitudeEquation:
    """The coefficients through ``order`` (3 or 5) at a threshold of `landau`.

    Errors are what more quadrature nodes change. Raises InputError for another order and ComputationError
    where the modes are too steep for float64.
    """
    if order not in (3, HIGHEST):
        raise InputError(f"order {order}: the emitted modules hold the orders 3 and {HIGHEST}")
    force, omega = threshold.force, threshold.omega
    count = len(nodes_at(rod.floats(), force, omega).u)
    solved, finer = (
        _of_follower(rod, force, omega, gauss_legendre(n)).solve(order) for n in (count, count + MORE_NODES)
    )
    best, other = (_equation(force, omega, s, order, {}) for s in (finer, solved))
    errors = {name: abs(c - other.coefficients[name]) for name, c in best.coefficients.items()}
    return _equation(
        force, omega, finer, order, errors,
        _change(best.A_tip2_curvature, other.A_tip2_curvature),
        _change(best.omega_curvature, other.omega_curvature),
    )  # fmt: skip


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
    if discriminant < 0:
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
    parts: Pool = {"third_re": third_harmonic.real}
    for name, symbol in LETTERS.items():
        if symbol in coefficients:
            c = coefficients[symbol]
            parts |= {f"{name}_re": c.real, f"{name}_im": c.imag}

    def predicted(name: str, **more: Any) -> Any:
        f: Callable[..., Any] = getattr(kernels, name)
        known = {**parts, **more}
        return f(*(known[a] for a in f.__code__.co_varnames[: f.__code__.co_argcount]))

    return predicted


def _change(a: float | None, b: float | None) -> float:
    return 0.0 if a is None or b is None else abs(a - b)


def terms(order: int) -> list[Index]:
    """(p, q, r), p >= q, of the responses through ``order``, in the order in which they can be solved."""
    found = [
        (p, q, r)
        for p in range(order + 1)
        for q in range(p + 1)
        for r in range(order + 1)
        if 2 <= p + q + 2 * r < order or (p + q + 2 * r == order and p == q + 1)
    ]
    return sorted(found, key=lambda i: (i[0] + i[1] + 2 * i[2], i))


@dataclass(frozen=True)
class _Solved:
    coefficients: dict[str, complex]
    third_harmonic: complex


class Responses:
    """Solves response after response; what is known is kept by name, at the nodes and at the tip.

    emitted: the rod's functions. parameters: its parameters by name, with ``lam`` = iω. mode: Y, Y_u, Theta,
    Theta_u at the nodes; mode_tip: the same at u = 1.
    """

    def __init__(self, emitted: Any, parameters: Pool, nodes: Nodes, mode: Pool, mode_tip: Pool) -> None:
        self.emitted, self.parameters, self.nodes = emitted, dict(parameters), nodes
        self.at_nodes: Pool = {"u": nodes.u, **mode}
        self.at_tip: Pool = {"u": 1.0, **mode_tip}
        self.lam = parameters["lam"]
        self.twice = nodes.from_clamp @ nodes.from_clamp  # Φ'' -> Φ − Φ'(0) u
        self.drag: tuple[Any, Any, Any] = self._call("drag_weights", self.at_nodes)
        for name, row, weight in zip(("Y", "Theta"), ("y_row", "theta_row"), self.drag[1:], strict=True):
            # λΓ(Y, Θ) = M(Y, Θ) gives the second derivative.
            y, y_u, y_uu, t, t_u, t_uu = self._call(row, self.at_nodes)
            rest = y * mode["Y"] + y_u * mode["Y_u"] + t * mode["Theta"] + t_u * mode["Theta_u"]
            self.at_nodes[f"{name}_uu"] = (self.lam * weight * mode[name] - rest) / (y_uu + t_uu)

    def solve(self, order: int, gauge: Mapping[Index, complex] | None = None) -> _Solved:
        """All responses through ``order``; gauge: tip displacement of resonant ones, where it is not 0."""
        coefficients = {}
        for index in terms(order):
            p, q, _ = index
            digits = "".join(map(str, index))
            names = (f"Y{digits}", f"Theta{digits}") if (p + q) % 2 else (f"X{digits}",)
            forcing = _tuple(self._call(f"{names[0]}_forcing", self.at_nodes))
            traction = _tuple(self._call(f"{names[0]}_traction", self.at_tip))
            right = np.concatenate([*(np.broadcast_to(f, self.nodes.u.shape) for f in forcing), traction])
            lam = (p - q) * self.lam
            if p == q + 1:
                solution, c = self._resonant(lam, right, (gauge or {}).get(index, 0.0))
                coefficients[f"c{digits}"] = self.parameters[f"c{digits}"] = c
            else:
                matrix = self._transverse(lam) if len(names) == 2 else self._longitudinal(lam)
                solution = _solve(matrix, right)
            self._keep(solution, names)
        return _Solved(coefficients, complex(self.at_tip.get("Y300", float("nan"))))

    def _call(self, name: str, pool: Mapping[str, Any], **changed: Any) -> Any:
        """An emitted function at whatever it asks for."""
        f: Callable[..., Any] = getattr(self.emitted, name)
        known = {**self.parameters, **pool, **changed}
        return f(*(known[a] for a in f.__code__.co_varnames[: f.__code__.co_argcount]))

    def _longitudinal(self, lam: complex) -> Complex:
        """λΓ − M and S on X: unknowns X'' at the nodes and X'(0)."""
        row = self._call("x_row", self.at_nodes)
        return self._block(row, self._call("x_tip_row", self.at_tip, lam=lam), lam * self.drag[0])

    def _transverse(self, lam: complex) -> Complex:
        """λΓ − M and S on (Y, Θ): unknowns Y'', Y'(0), Θ'', Θ'(0)."""
        n = len(self.nodes.u)
        interior, edges = [], []
        for k, name in enumerate(("y", "theta")):
            row = self._call(f"{name}_row", self.at_nodes)
            tip = self._call(f"{name}_tip_row", self.at_tip, lam=lam)
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
            [np.array(self._call(f"{name}_tip_row", self.at_tip, lam=lam)) for lam in (0.0, 1.0)]
            for name in ("y", "theta")
        ]
        return np.array([(one - none) @ mode for none, one in rows])

    def _tip_value(self) -> NDArray[np.float64]:
        """Φ(1) from (Φ'', Φ'(0))."""
        return np.append(self.nodes.weights @ self.nodes.from_clamp, 1.0)

    def _block(self, row: Any, tip: Any, drag: complex) -> Complex:
        """drag Φ − row·(Φ, Φ', Φ'') at the nodes and tip·(Φ, Φ') at u = 1, from (Φ'', Φ'(0))."""
        n, nodes = len(self.nodes.u), self.nodes
        by_value = np.hstack([self.twice, nodes.u[:, None]])
        by_slope = np.hstack([nodes.from_clamp, np.ones((n, 1))])
        by_top = np.hstack([np.eye(n), np.zeros((n, 1))])
        value, slope, top = (np.broadcast_to(c, (n,))[:, None] for c in row)
        interior = drag * by_value - value * by_value - slope * by_slope - top * by_top
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


def _of_follower(rod: RodParameters, force: float, omega: float, nodes: Nodes) -> Responses:
    """The responses of the default rod, whose critical mode is known in exponentials."""
    k1, k2, gamma3, gamma1 = rod.floats()
    parameters = {
        "k1": k1, "k2": k2, "gamma3": gamma3, "gamma1": gamma1, "force": force, "lam": 1j * omega,
    }  # fmt: skip
    mode = critical_mode(rod.floats(), force, omega, nodes)
    nu, _ = kernels.base_state(k1, k2, force)
    here = {"Y": mode.Y, "Y_u": mode.H + nu * mode.Theta, "Theta": mode.Theta, "Theta_u": mode.Theta_u}
    tip = {"Y": 1.0, "Y_u": nu * mode.Theta_tip, "Theta": mode.Theta_tip, "Theta_u": 0.0}
    return Responses(kernels, parameters, nodes, here, tip)


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
