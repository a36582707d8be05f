"""The full nonlinear rod in time, from the compressed straight rod, slightly perturbed (paper: sec:numerics).

The equations are those of `angleform`; SUNDIALS' CVODE integrates them with their exact Jacobian. It was
chosen by measurement at equal accuracy in A_tip (benchmarks/integrators.py). Rods other than the plain one
are integrated by `modelsimulation`.
"""

from __future__ import annotations

import contextlib
import io
import time as clock
from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal

import numpy as np
from numpy.typing import NDArray

from rodwnl.angleform import AngleForm, angle_form
from rodwnl.collocation import chebyshev
from rodwnl.errors import ComputationError, InputError
from rodwnl.inverse import leading_eigenvalues
from rodwnl.parameters import PLAIN, Number, RodParameters, exact, positive, require_rod, shown
from rodwnl.readout import Reading, read
from rodwnl.storage import file_attributes, require

if TYPE_CHECKING:
    import xarray

    from rodwnl.modelsimulation import LawForm

Array = NDArray[np.float64]

DEGREES = (16, 24, 32, 48, 64)  # what `nodes="auto"` tries; more would only add round-off
MOST_NODES = 128
RESOLVED = 1e-6  # relative size of the last Chebyshev coefficients with which a grid is fine enough
SAMPLES_PER_PERIOD = 32
FRAMES = 256  # the last samples, for which the whole shape is kept
MOST_SAMPLES = 2_000_000
OSCILLATING = 1e-6  # |Im λ|/|λ| of an eigenvalue that is not real up to round-off
ATOL = 1e-2  # absolute tolerance over the relative one: angles and displacements of 0.01 L count as large
LARGEST_PERTURBATION = 3
TITLE = "Planar Cosserat rod"  # how the title of every file begins
CHUNK = 2 * SAMPLES_PER_PERIOD  # samples read together; in the first the start meets the tip conditions

Progress = Callable[[float], None]


@dataclass(frozen=True)
class Simulation:
    """One run. Dimensionless: lengths in L, times in γ2 L⁴/k3, forces in k3/L².

    time, tip_x, tip_y, tip_theta (m,): uniform samples. frame_time (k,), x, y, theta, axial_force (k, N+1)
    at nodes (N+1,): the shapes at the last samples. tip_load (k, 2): the load at the tip then, along x and y,
    over the force and without its drag. complete: False where the run was interrupted. tail:
    relative size of the last Chebyshev coefficients. tip_residual: the largest of |x' − ν cosθ|,
    |y' − ν sinθ|, |θ'| at the tip, by differentiating the shapes; of another rod than the plain one the
    largest stress minus load there, over the force. evaluations: of the right-hand side and of its Jacobian.
    seconds: of the whole computation.
    """

    rod: RodParameters
    force: float
    perturbation: float
    rtol: float
    time: Array
    tip_x: Array
    tip_y: Array
    tip_theta: Array
    frame_time: Array
    nodes: Array
    x: Array
    y: Array
    theta: Array
    axial_force: Array
    tip_load: Array
    complete: bool
    tail: float
    tip_residual: float
    evaluations: tuple[int, int]
    seconds: float

    @property
    def resolved(self) -> bool:
        """Whether the grid was fine enough."""
        return self.tail <= RESOLVED

    @cached_property
    def reading(self) -> Reading:
        """Amplitude and frequency of the tip in the second half of the run, or where it comes to rest.

        An implicit integrator comes to rest to rounding: what is added to the error of y_tip is the grid's.
        """
        reading = read(self.time, self.tip_y)
        if reading.y_tip is None or reading.y_tip_error is None:
            return reading
        return replace(reading, y_tip_error=reading.y_tip_error + self.tail * abs(reading.y_tip))


def simulate(
    rod: RodParameters,
    force: Number,
    time: Number = 5,
    perturbation: Number = "1e-2",
    nodes: int | Literal["auto"] = "auto",
    rtol: Number = 1e-8,
    progress: Progress | None = None,
) -> Simulation:
    """Integrate the exact equations from t = 0 to `time`.

    force: 0 < F < k1. perturbation: amplitude of the sines added to y (in L) and θ. nodes: intervals of the
    Chebyshev grid; "auto" refines it until the spectrum of the shapes has decayed. rtol: tolerance of the
    integrator; the default left an error of 5e-7 in A_tip at force 38 (k1 = k2 = 1e4, gamma3 = 1e-4).
    progress: called with the part of the run that is done.

    An interrupt (Ctrl-C) ends the run early, and what was computed is returned with complete = False. Raises
    InputError for values outside these ranges and ComputationError where the integrator gives up.
    """
    started = clock.perf_counter()
    require_rod(rod)
    F = _checked_force(rod, force)
    duration, epsilon = float(positive("time", time)), float(exact("perturbation", perturbation))
    if abs(epsilon) > LARGEST_PERTURBATION:
        raise InputError(
            f"perturbation is {epsilon:g}, but its size must not exceed {LARGEST_PERTURBATION} (L and rad): "
            "beyond, the tip is turned by half a turn and the start is not resolved"
        )
    tolerance = float(positive("rtol", rtol))
    if not 1e-13 <= tolerance <= 1e-3:
        raise InputError(f"rtol is {rtol}, but it must lie between 1e-13 and 1e-3")
    degrees = DEGREES if nodes == "auto" else (_checked_nodes(nodes),)
    step = sampling_step(rod, F, duration)
    for degree in degrees:
        form = _form(rod, F, degree)
        run = _Run(form, step, duration, tolerance, limit=None if degree == degrees[-1] else RESOLVED)
        start = perturbed(form, epsilon) if isinstance(form, AngleForm) else form.perturbed(epsilon)
        if run.integrate(start, progress):
            break
    return run.result(rod, epsilon, clock.perf_counter() - started)


def _form(rod: RodParameters, force: float, degree: int) -> AngleForm | LawForm:
    if rod.model == PLAIN:
        return angle_form(rod, force, degree)
    from rodwnl.modelsimulation import law_form

    return law_form(rod, force, degree)


def perturbed(form: AngleForm, epsilon: float) -> Array:
    """The initial state: x = νu, y = ε sin(πu/2), θ = ε sin(πu/2), in the unknowns of `angleform`."""
    wave = np.pi / 2 * form.nodes
    theta, y_u = epsilon * np.sin(wave), epsilon * np.pi / 2 * np.cos(wave)
    c, s = np.cos(theta), np.sin(theta)
    return form.state(form.nu * c + y_u * s, y_u * c - form.nu * s, theta)


def sampling_step(rod: RodParameters, force: float, duration: float) -> float:
    """Time between samples: divides `duration` and samples the straight rod's leading oscillation well.

    Where nothing oscillates, the rate at which the leading mode decays stands for the frequency.
    """
    at = np.array([force])
    if rod.model == PLAIN:
        eigenvalues = leading_eigenvalues(rod.floats(), at)[0][0]
    else:
        from rodwnl import collocated

        eigenvalues = collocated.leading_eigenvalues(rod, at)[0][0]
    oscillating = eigenvalues[eigenvalues.imag > OSCILLATING * np.abs(eigenvalues)]
    candidates = oscillating if oscillating.size else eigenvalues
    leading = float(np.abs(candidates[candidates.real.argmax()]))
    samples = max(8 * SAMPLES_PER_PERIOD, int(np.ceil(duration * leading / (2 * np.pi) * SAMPLES_PER_PERIOD)))
    if samples > MOST_SAMPLES:
        raise InputError(
            f"time is {duration:g}, which takes {samples} samples ({SAMPLES_PER_PERIOD} a period at "
            f"frequency {leading:.4g}), but at most {MOST_SAMPLES} are kept; simulate a shorter time"
        )
    return duration / samples


def expected_size(rod: RodParameters, force: Number, time: Number) -> int:
    """Bytes of the file that a run at this force will need, at most."""
    duration = float(positive("time", time))
    step = sampling_step(rod, _checked_force(rod, force), duration)
    return 8 * (4 * round(duration / step) + 4 * FRAMES * (MOST_NODES + 1)) + 100_000


def _checked_force(rod: RodParameters, force: Number) -> float:
    F = float(rod.checked_force(force))
    if F > 0:
        return F
    raise InputError(f"force is {shown(force)}, but a simulation needs a follower force: 0 < force < k1")


def _checked_nodes(nodes: int) -> int:
    if isinstance(nodes, int) and 8 <= nodes <= 128:
        return nodes
    raise InputError(
        f"nodes is {nodes}, but it must be auto or a whole number from 8 to 128 (round-off grows beyond)"
    )


class _Run:
    """One integration on one grid: CVODE, and what is kept of its states."""

    def __init__(
        self, form: AngleForm | LawForm, step: float, duration: float, rtol: float, limit: float | None
    ) -> None:
        self.form, self.step, self.rtol, self.limit = form, step, rtol, limit
        self.samples = round(duration / step) + 1
        self.tips: list[Array] = []  # (3, samples of a chunk) each
        self.states: Array = np.empty((0, form.size))  # the last FRAMES, and those not yet read
        self.unread: list[Array] = []
        self.tail, self.complete, self.evaluations = 0.0, True, (0, 0)

    def integrate(self, q: Array, progress: Progress | None) -> bool:
        """Run to the end or to an interrupt; False once the tail passes its limit: the grid is too coarse."""
        self._keep(q, last=True)
        one_thread = require("threadpoolctl", "simulate").threadpool_limits(1)
        with one_thread, np.errstate(over="ignore", invalid="ignore"):  # the integrator notices
            solver = self._solver(q)
            try:
                for index in range(1, self.samples):
                    self._keep(self._advance(solver, index * self.step), last=index == self.samples - 1)
                    if self.limit is not None and self.tail > self.limit:
                        return False
                    if progress is not None and not self.unread:
                        progress(index / (self.samples - 1))
            except KeyboardInterrupt:
                self.complete = False
                self._read()
        return True

    def _solver(self, q: Array) -> Any:
        form = self.form
        if not isinstance(form, AngleForm):
            return form.solver(q, self.rtol)
        sundae = require("sksundae.cvode", "simulate")

        def rhs(t: float, q: Array, q_t: Array) -> None:
            q_t[:] = form.rhs(q)

        def jacobian(t: float, q: Array, q_t: Array, J: Array) -> None:
            J[:] = form.jacobian(q)

        solver = sundae.CVODE(
            rhs, jacfn=jacobian, rtol=self.rtol, atol=ATOL * self.rtol, max_num_steps=100_000
        )
        solver.init_step(0.0, q)
        return solver

    def _advance(self, solver: Any, time: float) -> Array:
        with contextlib.redirect_stdout(io.StringIO()):  # SUNDIALS reports failures there as well
            try:
                now = solver.step(time)
            except FloatingPointError as error:
                raise ComputationError(self._failure(time, str(error))) from None
        self.evaluations = (int(now.nfev), int(now.njev))
        if not now.success or not np.isfinite(now.y).all():
            raise ComputationError(self._failure(now.t, now.message))
        return np.asarray(now.y)

    def _failure(self, time: float, reason: str) -> str:
        return (
            f"the integrator gave up at t = {time:.3g} of {(self.samples - 1) * self.step:g} "
            f"({reason.rstrip('.')}). A smaller perturbation, a larger rtol or more nodes may help"
        )

    def _keep(self, q: Array, last: bool) -> None:
        self.unread.append(q)
        if last or len(self.unread) >= CHUNK:
            self._read()

    def _read(self) -> None:
        """Take from the new states what is kept of all."""
        if not self.unread:
            return
        new = np.array(self.unread)
        self.unread = []
        if self.tips:
            self.tail = max(self.tail, self.form.tail(new))
        self.tips.append(np.array(self.form.tip(new)))
        self.states = np.concatenate([self.states, new])[-FRAMES:]

    def result(self, rod: RodParameters, epsilon: float, seconds: float) -> Simulation:
        tip = np.concatenate(self.tips, axis=1)
        time = np.arange(tip.shape[1]) * np.float64(self.step)
        x, y, theta, axial_force = self.form.fields(self.states)
        return Simulation(
            rod=rod,
            force=self.form.force,
            perturbation=epsilon,
            rtol=self.rtol,
            time=time,
            tip_x=tip[0],
            tip_y=tip[1],
            tip_theta=tip[2],
            frame_time=time[-len(self.states) :],
            nodes=self.form.nodes,
            x=x,
            y=y,
            theta=theta,
            axial_force=axial_force,
            tip_load=_tip_load(self.form, theta[:, -1]),
            complete=self.complete,
            tail=self.tail or self.form.tail(self.states[-1:]),  # of a run that ended in its first chunk
            tip_residual=_tip_residual(self.form, x, y, theta)
            if isinstance(self.form, AngleForm)
            else self.form.tip_residual(self.states),
            evaluations=self.evaluations,
            seconds=seconds,
        )


def _tip_residual(form: AngleForm, x: Array, y: Array, theta: Array) -> float:
    """How well x' = ν cosθ, y' = ν sinθ, θ' = 0 hold at u = 1 (eq:follower), from the shapes."""
    end, tip = chebyshev(form.nodes.size - 1).first[-1], theta[:, -1]
    residuals = (x @ end - form.nu * np.cos(tip), y @ end - form.nu * np.sin(tip), theta @ end)
    return max(float(np.abs(r).max()) for r in residuals)


def _tip_load(form: AngleForm | LawForm, theta: Array) -> Array:
    """The load along x and y over the force, (k, 2), at angles (k,) of a tip at rest."""
    along, across = (-1.0, 0.0) if isinstance(form, AngleForm) else form.tip_load(theta)
    c, s = np.cos(theta), np.sin(theta)
    return np.stack([along * c - across * s, along * s + across * c], axis=-1)


def is_run(path: Path) -> bool:
    """Whether this file was written from a dataset of `to_dataset`."""
    found = file_attributes(path)
    return found.get("title", "").startswith(TITLE) and "spectral_tail" in found


def to_dataset(run: Simulation) -> xarray.Dataset:
    """The run with names, units and everything that is needed to repeat it."""
    xr: Any = require("xarray", "simulate")
    reading, plain = run.reading, run.rod.model == PLAIN
    read_values = {
        name: value
        for name in ("A_tip", "A_tip_error", "omega", "omega_error", "growth", "y_tip", "y_tip_error")
        if (value := getattr(reading, name)) is not None
    }
    length, duration, force = "L", "gamma2 L^4/k3", "k3/L^2"

    def variable(dims: tuple[str, ...], values: Array, units: str, long_name: str) -> Any:
        return (dims, values, {"units": units, "long_name": long_name})

    frame = ("frame", "node")
    dataset: xarray.Dataset = xr.Dataset(
        {
            "tip_x": variable(("time",), run.tip_x, length, "x at the tip"),
            "tip_y": variable(("time",), run.tip_y, length, "y at the tip"),
            "tip_theta": variable(("time",), run.tip_theta, "rad", "angle of the cross-section at the tip"),
            "frame_time": variable(
                ("frame",), run.frame_time, duration, "time of the shapes, the last of the run"
            ),
            "x": variable(frame, run.x, length, "position along the straight rod"),
            "y": variable(frame, run.y, length, "position across the straight rod"),
            "theta": variable(frame, run.theta, "rad", "angle of the cross-section"),
            "F1": variable(
                frame, run.axial_force, force, "axial force k1 (h1 - 1)" if plain else "axial force"
            ),
            "load_x": variable(
                ("frame",), run.tip_load[:, 0], "1", "load at the tip along x, over the force"
            ),
            "load_y": variable(
                ("frame",), run.tip_load[:, 1], "1", "load at the tip along y, over the force"
            ),
        },
        coords={
            "time": variable(("time",), run.time, duration, "time"),
            "u": variable(("node",), run.nodes, length, "material coordinate, 0 at the clamp, 1 at the tip"),
        },
        attrs={
            "title": f"{TITLE} under a follower force, full nonlinear equations"
            if plain
            else f"{TITLE} {run.rod.model_name!r}, full nonlinear equations",
            "conventions": "dimensionless: lengths in L, times in gamma2 L^4/k3, forces in k3/L^2",
            **({} if plain else {"model": run.rod.model_name}),
            "parameters": " ".join(run.rod.texts()),
            **run.rod.texts(),
            "force": run.force,
            "perturbation": run.perturbation,
            "rtol": run.rtol,
            "nodes": run.nodes.size - 1,
            "complete": int(run.complete),
            "resolved": int(run.resolved),
            "spectral_tail": run.tail,
            "tip_residual": run.tip_residual,
            "state": reading.state,
            **read_values,
        },
    )
    return dataset
