"""What the page shows of a rod at a force, as plain numbers for JSON."""

from __future__ import annotations

from functools import lru_cache
from math import isfinite, sqrt
from typing import Any

import numpy as np

from rodwnl import kernels
from rodwnl.batch import DEFAULT_MAX_FORCE, Status, landau_batch
from rodwnl.batch_characteristic import Real
from rodwnl.errors import ComputationError
from rodwnl.inverse import inverse_operator, leading_eigenvalues
from rodwnl.modes import critical_mode, nodes_at
from rodwnl.parameters import Number, RodParameters

FORCES = 28  # at which the spectrum is drawn
LINES = 6  # eigenvalues drawn
ORBITS = 24  # of a branch

State = dict[str, Any]


def state(rod: RodParameters, force: Number) -> State:
    """Thresholds with their coefficients, the spectrum over the force; predictions and eigenvalues at one."""
    at = float(rod.checked_force(force))
    parameters = rod.floats()
    found = _of_rod(parameters)
    eigenvalues, _ = leading_eigenvalues(parameters, np.array([at]), LINES)
    predictions = [_prediction(t, at) for t in found["thresholds"]]
    return found | {"force": at, "eigenvalues": _pairs(eigenvalues[0]), "predictions": predictions}


@lru_cache(maxsize=64)
def _of_rod(parameters: tuple[float, float, float, float]) -> State:
    """What does not depend on the force, kept while only the force is changed."""
    k1 = parameters[0]
    batch = landau_batch(*parameters)
    if batch.status == Status.FAILED:
        raise ComputationError(f"this rod cannot be computed: {batch.reasons[0]}")
    thresholds = [_threshold(parameters, batch, i) for i in range(int(batch.count))]
    top = min(k1, DEFAULT_MAX_FORCE, 2 * max([t["force"] for t in thresholds], default=100.0) + 20)
    forces = np.linspace(0, top * (1 - 1e-9), FORCES)
    return {
        "status": Status(int(batch.status)).name.lower(),
        "searched": min(k1, DEFAULT_MAX_FORCE),
        "thresholds": thresholds,
        "spectrum": {"force": forces.tolist(), "growth": _growth(parameters, forces).tolist()},
    }


def _growth(parameters: tuple[float, float, float, float], forces: Real) -> Real:
    """Real parts of the leading eigenvalues, (forces, LINES), for the eye: on few nodes, without slopes."""
    k1, k2, _, _ = parameters
    wave = float(np.sqrt(np.max((1 - forces / k1 + forces / k2) * forces)))
    inverse = np.linalg.eigvals(inverse_operator(parameters, forces, 16 + int(wave)))
    order = np.argsort(-np.abs(inverse), axis=-1)[:, :LINES]
    return np.asarray((1 / np.take_along_axis(inverse, order, -1)).real)


def _threshold(parameters: tuple[float, float, float, float], batch: Any, i: int) -> State:
    force, omega = float(batch.force[i]), float(batch.omega[i])
    mode = critical_mode(parameters, force, omega, nodes_at(parameters, force, omega))
    u = nodes_at(parameters, force, omega).u
    alpha, beta = complex(batch.alpha[i]), complex(batch.beta[i])
    return {
        "force": force,
        "omega": omega,
        "alpha": [alpha.real, alpha.imag],
        "beta": [beta.real, beta.imag],
        "crossing": "destabilizing" if batch.crossing[i] > 0 else "restabilizing",
        "criticality": "supercritical" if alpha.real < 0 else "subcritical",
        "A_tip2_slope": float(batch.A_tip2_slope[i]),
        "omega_slope": float(batch.omega_slope[i]),
        "error": float(batch.error[i]),
        "mode": {"u": [0.0, *u.tolist(), 1.0], "Y": [[0.0, 0.0], *_pairs(mode.Y), [1.0, 0.0]]},
    }


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


def orbits(rod: RodParameters, number: int) -> State:
    """The branch of orbits of the full nonlinear rod from a threshold: force, A_tip and stability of each."""
    from rodwnl.branches import branch

    thresholds = _of_rod(rod.floats())["thresholds"]
    if not 0 <= number < len(thresholds):
        raise ComputationError(f"there is no threshold {number + 1}: the rod has {len(thresholds)}")
    start = thresholds[number]
    found = branch(rod, start["force"], start["omega"], most_points=ORBITS, locate_events=False)
    points = [[p.cycle.force, p.cycle.tip_amplitude, p.stable] for p in found.points]
    return {"threshold": number, "points": points}


def _pairs(numbers: Any) -> list[list[float]]:
    return [[z.real, z.imag] for z in numbers.tolist()]
