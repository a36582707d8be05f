"""What an error in a printed equation would do to α and β on the paper's four rods.

The chain of formulas that leads to the coefficients (`derivation.paper.chain`) is evaluated twice on the same
modes, as derived and with the printed equation in it. Relative changes are what is reported.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache
from typing import TYPE_CHECKING, Any

import numpy as np

from rodwnl import kernels
from rodwnl.inverse import Complex
from rodwnl.modes import adjoint_mode, critical_mode, nodes_at, two_point
from rodwnl.quadrature import Nodes
from rodwnl.spectrum import hopf_thresholds
from rodwnl.tables import printed_rows

if TYPE_CHECKING:
    from derivation.paper.algebra import Atom, Poly
    from derivation.paper.chain import Chain
    from derivation.paper.notation import Notation
    from derivation.paper.rows import Row
    from derivation.paper.theory import Theory

#: Below this a relative change is rounding: the modes are good to about 1e-11.
ROUNDING = 1e-9


@dataclass(frozen=True)
class Point:
    """A rod at one of its thresholds: values of constants by name, of the modes by (name, u-derivatives)."""

    name: str
    constants: dict[str, complex]
    shapes: dict[tuple[str, int], Complex]
    tips: dict[tuple[str, int], complex]
    nodes: Nodes


@cache
def points() -> tuple[Point, ...]:
    """The rows of tab:parameters."""
    return tuple(
        _point(row.name, row.rod.floats(), row.threshold, row.rod)
        for row in printed_rows()
        if row.table == "tab:parameters"
    )


def _point(name: str, parameters: Any, number: int, rod: Any) -> Point:
    threshold = hopf_thresholds(rod).thresholds[number - 1]
    force, omega = threshold.force, threshold.omega
    nodes = nodes_at(parameters, force, omega)
    mode = critical_mode(parameters, force, omega, nodes)
    adjoint = adjoint_mode(parameters, force, omega, nodes)
    k1, k2, gamma3, gamma1 = parameters
    nu, mu = kernels.base_state(k1, k2, force)
    constants = {
        "k1": k1, "k2": k2, "gamma1": gamma1, "gamma3": gamma3, "force": force, "nu": nu, "mu": mu,
        "omega": omega,
    }  # fmt: skip
    shapes = {
        ("Y", 0): mode.Y, ("Y", 1): mode.H + nu * mode.Theta, ("H", 0): mode.H, ("Theta", 0): mode.Theta,
        ("Theta", 1): mode.Theta_u, ("Psi_Y", 0): adjoint.Psi_Y, ("Psi_Theta", 0): adjoint.Psi_Theta,
    }  # fmt: skip
    # λY = k2 Y'' − μΘ',  γ3 λ Θ = Θ'' + μH at the nodes
    shapes["Y", 2] = (1j * omega * mode.Y + mu * mode.Theta_u) / k2
    shapes["Theta", 2] = 1j * gamma3 * omega * mode.Theta - mu * mode.H
    tips = {
        ("Y", 0): 1.0, ("Y", 1): nu * mode.Theta_tip, ("H", 0): 0.0,
        ("Theta", 0): mode.Theta_tip, ("Theta", 1): 0.0,
        ("Psi_Y", 0): adjoint.Psi_Y_tip, ("Psi_Theta", 0): _at_end(adjoint.Psi_Theta, nodes, 1),
    }  # fmt: skip
    return Point(name, constants, shapes, tips, nodes)


def _series(values: Complex, nodes: Nodes) -> Complex:
    """The coefficients of the Legendre series through values at the nodes."""
    k = np.arange(len(nodes.u))
    matrix = np.polynomial.legendre.legvander(2 * nodes.u - 1, len(nodes.u) - 1)
    return np.asarray((2 * k + 1) * (matrix.T @ (nodes.weights * values)))


def _at_end(values: Complex, nodes: Nodes, place: int) -> complex:
    """f(0) or f(1): P_k(±1) = (±1)^k."""
    return complex(np.polynomial.legendre.legval(2 * place - 1, _series(values, nodes)))


def _slope(values: Complex, nodes: Nodes) -> Complex:
    """f' at the nodes."""
    slopes = np.polynomial.legendre.legder(_series(values, nodes))
    return np.asarray(2 * np.polynomial.legendre.legval(2 * nodes.u - 1, slopes))


def effect(row: Row, notation: Notation, theory: Theory) -> dict[str, Any]:
    """Relative changes of α and β by rod, as texts, or a note that says why there are none.

    {"note": "", "rods": [{"row": "(a, b)", "alpha": "1.2e-01", "beta": "0"}, ...]}
    """
    from derivation.paper.chain import chain_of, changed

    other = changed(row, notation, theory)
    if isinstance(other, str):
        return {"note": other, "rods": []}
    derived = chain_of(theory.d)
    rods = []
    for point in points():
        before = _coefficients(derived, point)
        after = _coefficients(other, point)
        changes = (abs(a - b) / abs(b) for a, b in zip(after, before, strict=True))
        alpha, beta = ("0" if x < ROUNDING else f"{x:.1e}" for x in changes)
        rods.append({"row": point.name, "alpha": alpha, "beta": beta})
    return {"note": "", "rods": rods}


def _coefficients(chain: Chain, point: Point) -> tuple[complex, complex]:
    """α and β by the chain at one point."""
    values = _Values(chain, point)
    weights = point.nodes.weights
    norm = weights @ values(chain.norm)
    cubic = weights @ (
        values.star("Psi_Y") * values(chain.g["g1"]) + values.star("Psi_Theta") * values(chain.g["g3"])
    )
    detuning = weights @ (
        values.star("Psi_Y") * values(chain.g["g2"]) + values.star("Psi_Theta") * values(chain.g["g4"])
    )
    found = {"alpha": cubic / norm, "beta": detuning / norm}
    for name, key in (("alpha", "cubic"), ("beta", "detuning")):
        if key in chain.boundary:
            found[name] += values(chain.boundary[key]) / norm
        if name in chain.whole:
            found[name] = values(chain.whole[name])
    return complex(found["alpha"]), complex(found["beta"])


class _Values:
    """Polynomials at one point: arrays over the nodes, or numbers."""

    def __init__(self, chain: Chain, point: Point) -> None:
        self.point = point
        self.shapes, self.tips = dict(point.shapes), dict(point.tips)
        for name in ("X0", "X2"):
            drag, slope = complex(self(chain.drag[name])), complex(self(chain.slope[name]))
            forcing = np.asarray(self(chain.forcing[name]) * np.ones_like(point.nodes.u))
            k1 = float(point.constants["k1"].real)
            self.shapes[name, 0], self.shapes[name, 1] = two_point(k1, drag, forcing, slope, point.nodes)
        for name in ("P0", "P2"):
            self.shapes[name, 0] = np.asarray(self(chain.tension[name]))

    def star(self, name: str) -> Complex:
        return np.asarray(self.shapes[name, 0].conj())

    def __call__(self, p: Poly) -> Any:
        total: Any = 0.0
        for monomial, c in p.terms.items():
            term: Any = complex(float(c.x), float(c.y))
            for a, e in monomial:
                term = term * self._atom(a) ** e
            total = total + term
        return total

    def _atom(self, a: Atom) -> Any:
        if a.kind == "integral":
            return self.point.nodes.weights @ (self(a.arg) * np.ones_like(self.point.nodes.u))
        if a.kind == "inverse":
            return 1 / self(a.arg)
        if a.kind == "sqrt":
            return np.sqrt(self(a.arg))
        if a.kind == "constant":
            return self.point.nodes.u if a.name == "u" else self.point.constants[a.name]
        value = self._shape(a.name, a.u) if a.place is None else self._end(a.name, a.u, a.place)
        return np.conj(value) if a.bar else value

    def _shape(self, name: str, u: int) -> Complex:
        if (name, u) not in self.shapes:
            self.shapes[name, u] = _slope(self._shape(name, u - 1), self.point.nodes)
        return self.shapes[name, u]

    def _end(self, name: str, u: int, place: int) -> complex:
        if place == 1 and (name, u) in self.tips:
            return self.tips[name, u]
        return _at_end(self._shape(name, u), self.point.nodes, place)
