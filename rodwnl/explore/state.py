"""What the page shows of a rod at a force, as plain numbers for JSON."""

from __future__ import annotations

from collections.abc import Callable
from fractions import Fraction
from functools import lru_cache
from math import isfinite, sqrt
from typing import Any

import numpy as np

from rodwnl import kernels
from rodwnl.batch import DEFAULT_MAX_FORCE, Status, landau_batch
from rodwnl.batch_characteristic import Real
from rodwnl.errors import ComputationError
from rodwnl.inverse import Complex, inverse_operator, leading_eigenvalues
from rodwnl.modes import critical_mode, nodes_at
from rodwnl.parameters import PLAIN, Number, RodParameters, name_of
from rodwnl.straightrod import straight_rod

FORCES = 28  # at which the spectrum is drawn
LINES = 6  # eigenvalues drawn
ORBITS = 24  # of a branch

State = dict[str, Any]


def about(model: str, own: tuple[tuple[str, Fraction], ...]) -> State:
    """What the page says of the rod, and the sliders of the parameters that only this rod has."""
    if model == PLAIN:
        return {"title": "A rod under a follower force", "parameters": []}
    sliders = [{"name": name, "start": float(value), **_range(float(value))} for name, value in own]
    return {"title": f"Rod {name_of(model)!r}: {kernels.title(model)}", "parameters": sliders}


def _range(value: float) -> dict[str, float]:
    """Where a slider for a parameter of this value ends: at 0 and at twice the value; 0 and 1 for 0."""
    low, high = sorted((0.0, 2 * value)) if value else (0.0, 1.0)
    return {"low": low, "high": high}


def state(rod: RodParameters, force: Number) -> State:
    """Thresholds with their coefficients, the spectrum over the force; predictions and eigenvalues at one."""
    at = float(rod.checked_force(force))
    found = _of_rod(rod)
    eigenvalues = _leading(rod, np.array([at]))[0]
    predictions = [_prediction(t, at) for t in found["thresholds"]]
    return found | {"force": at, "eigenvalues": _pairs(eigenvalues), "predictions": predictions}


@lru_cache(maxsize=64)
def _of_rod(rod: RodParameters) -> State:
    """What does not depend on the force, kept while only the force is changed."""
    found = _plain(rod.floats()) if rod.model == PLAIN else _any(rod)
    searched = found["searched"]
    top = min(searched, 2 * max([t["force"] for t in found["thresholds"]], default=100.0) + 20)
    forces = np.linspace(0, top * (1 - 1e-9), FORCES)
    growth = _growth(rod.floats(), forces) if rod.model == PLAIN else _leading(rod, forces).real
    return found | {"spectrum": {"force": forces.tolist(), "growth": growth.tolist()}}


def _plain(parameters: tuple[float, float, float, float]) -> State:
    """The plain rod's thresholds, by the fastest route there is."""
    batch = landau_batch(*parameters)
    if batch.status == Status.FAILED:
        raise ComputationError(f"this rod cannot be computed: {batch.reasons[0]}")
    thresholds = []
    for i in range(int(batch.count)):
        force, omega = float(batch.force[i]), float(batch.omega[i])
        nodes = nodes_at(parameters, force, omega)
        thresholds.append({
            "force": force,
            "omega": omega,
            "alpha": _pair(batch.alpha[i]),
            "beta": _pair(batch.beta[i]),
            "crossing": "destabilizing" if batch.crossing[i] > 0 else "restabilizing",
            "criticality": "supercritical" if batch.alpha[i].real < 0 else "subcritical",
            "A_tip2_slope": float(batch.A_tip2_slope[i]),
            "omega_slope": float(batch.omega_slope[i]),
            "error": float(batch.error[i]),
            "mode": _mode(nodes.u, critical_mode(parameters, force, omega, nodes).Y),
        })  # fmt: skip
    return {
        "status": Status(int(batch.status)).name.lower(),
        "searched": min(parameters[0], DEFAULT_MAX_FORCE),
        "thresholds": thresholds,
        "buckling": [],
    }


def _any(rod: RodParameters) -> State:
    """Another rod's thresholds; where it buckles."""
    from rodwnl import expansion, thresholds
    from rodwnl.coefficients import landau

    found = landau(rod)
    entries = []
    for c in found:
        nodes = thresholds.nodes_at(rod, c.force, c.omega)
        mode = expansion.critical_mode(straight_rod(rod, c.force), c.omega, nodes)
        entries.append({
            "force": c.force,
            "omega": c.omega,
            "alpha": _pair(c.alpha),
            "beta": _pair(c.beta),
            "crossing": c.crossing,
            "criticality": c.criticality,
            "A_tip2_slope": c.A_tip2_slope,
            "omega_slope": c.omega_slope,
            "error": 10**-c.digits,
            "mode": _mode(nodes.u, mode.Y),
        })  # fmt: skip
    return {
        "status": "ok" if entries else "none",
        "searched": float(found.search.max_force),
        "thresholds": entries,
        "buckling": [t.force for t in found.search.steady],
    }


def _leading(rod: RodParameters, forces: Real) -> Complex:
    """The leading eigenvalues at these forces, (forces, LINES)."""
    if rod.model == PLAIN:
        return leading_eigenvalues(rod.floats(), forces, LINES)[0]
    from rodwnl import collocated

    return collocated.leading_eigenvalues(rod, forces, LINES)[0]


def _growth(parameters: tuple[float, float, float, float], forces: Real) -> Real:
    """Real parts of the plain rod's, for the eye: on few nodes, without slopes."""
    k1, k2, _, _ = parameters
    wave = float(np.sqrt(np.max((1 - forces / k1 + forces / k2) * forces)))
    inverse = np.linalg.eigvals(inverse_operator(parameters, forces, 16 + int(wave)))
    order = np.argsort(-np.abs(inverse), axis=-1)[:, :LINES]
    return np.asarray((1 / np.take_along_axis(inverse, order, -1)).real)


def _mode(u: Real, Y: Complex) -> State:
    return {"u": [0.0, *u.tolist(), 1.0], "Y": [[0.0, 0.0], *_pairs(Y), [1.0, 0.0]]}


def _pair(value: complex) -> list[float]:
    return [float(value.real), float(value.imag)]


def _prediction(threshold: State, force: float) -> State:
    """The branch from one threshold at this force (paper: eq:tipamplitude, eq:tipfrequency)."""
    detuning = force - threshold["force"]
    (a, _), (b, _) = threshold["alpha"], threshold["beta"]
    squared = float(kernels.tip_amplitude_squared(detuning, a, b))
    if not (squared > 0 and isfinite(squared)):
        return {"exists": False}
    omega = threshold["omega"] + detuning * threshold["omega_slope"]
    return {
        "exists": True,
        "stable": bool(kernels.radial_stability(detuning, b) < 0),
        "A_tip": sqrt(squared),
        "omega": omega,
    }


def orbits(rod: RodParameters, number: int, watch: Callable[[Any], None] = lambda point: None) -> State:
    """The branch of orbits of the full nonlinear rod from a threshold: force, A_tip and stability of each.

    joins: the force of the Hopf point at which it ends, or None. watch: called with every orbit.
    """
    from rodwnl.branches import branch

    thresholds = _of_rod(rod)["thresholds"]
    if not 0 <= number < len(thresholds):
        raise ComputationError(f"there is no threshold {number + 1}: the rod has {len(thresholds)}")
    start = thresholds[number]
    found = branch(rod, start["force"], start["omega"], most_points=ORBITS, watch=watch, locate_events=False)
    points = [[p.cycle.force, p.cycle.tip_amplitude, p.stable] for p in found.points]
    joins = found.last.force if found.end == "Hopf point" else None
    return {"threshold": number, "points": points, "joins": joins}


def _pairs(numbers: Any) -> list[list[float]]:
    return [[z.real, z.imag] for z in numbers.tolist()]
