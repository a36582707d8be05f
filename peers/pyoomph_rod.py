"""The rod for pyoomph (PyPI, GPL: run as a process of its own): finite elements, Hopf tracking, orbits.

    python pyoomph_rod.py '{"k1": 200, "k2": 1e4, "gamma3": 1e-4, "gamma1": 0.5, "force": 49.8,
                            "omega": 334, "elements": 80, "steps": 40, "distance": 0.02}'

`force` and `omega` are where the search starts; `elements` divide the rod and `steps` the period; the orbits
lie `distance` and twice that from the threshold. Lengths in L, times in γ2 L⁴/k3. The last line printed is
one JSON object.
"""

import json
import sys
import tempfile
import time

import numpy as np
from pyoomph import (
    DirichletBC,
    Equations,
    InitialCondition,
    IntegralObservables,
    LineMesh,
    Problem,
)
from pyoomph.expressions import cos, grad, partial_t, sin, testfunction, var, weak

SAMPLES = 64  # of the tip over a period


class Rod(Equations):
    """Balance of force and moment, n' = γ1 v1 e1 + γ2 v2 e2 and M' + h1 F2 − h2 F1 = γ3 θ_t, in weak form.

    The drag is taken to the other side, r_t = D(θ) n' with D = e1 e1ᵀ/γ1 + e2 e2ᵀ, so that the mass matrix is
    constant; integrated by parts with test functions w, ∫ r_t·w + n·(D w)' = [n·D w] where n(1) = −F e1(1).
    """

    def __init__(self, k1, k2, gamma3, gamma1):
        super().__init__()
        self.rod = k1, k2, gamma3, gamma1

    def define_fields(self):
        for name in ("px", "py", "theta"):
            self.define_scalar_field(name, "C2")

    def define_residuals(self):
        k1, k2, gamma3, gamma1 = self.rod
        theta, w1, w2 = var("theta"), testfunction("px"), testfunction("py")
        c, s = cos(theta), sin(theta)
        x_u, y_u, bend = (grad(var(name))[0] for name in ("px", "py", "theta"))
        h1, h2 = c * x_u + s * y_u, c * y_u - s * x_u
        F1, F2 = k1 * (h1 - 1), k2 * h2
        # n·(D w)' with e1' = θ' e2, e2' = −θ' e1
        along, across = c * w1 + s * w2, c * w2 - s * w1
        along_u = c * grad(w1)[0] + s * grad(w2)[0] + bend * across
        across_u = c * grad(w2)[0] - s * grad(w1)[0] - bend * along
        tension = (F1 / gamma1) * along_u + F2 * across_u
        # (D w)' also turns the frame that D is diagonal in
        turned = bend * (F2 * along / gamma1 - F1 * across)
        self.add_residual(weak(partial_t(var("px")), w1) + weak(partial_t(var("py")), w2))
        self.add_residual(weak(tension + turned, 1))
        self.add_residual(weak(gamma3 * partial_t(theta) - h1 * F2 + h2 * F1, testfunction("theta")))
        self.add_residual(weak(bend, grad(testfunction("theta"))[0]))


class Follower(Equations):
    """The load at u = 1: n·D w = −F e1·w/γ1; the moment vanishes by itself."""

    def __init__(self, force, gamma1):
        super().__init__()
        self.force, self.gamma1 = force, gamma1

    def define_residuals(self):
        theta, w1, w2 = var("theta"), testfunction("px"), testfunction("py")
        self.add_residual(weak(self.force / self.gamma1 * (cos(theta) * w1 + sin(theta) * w2), 1))


class Flutter(Problem):
    def __init__(self, k1, k2, gamma3, gamma1, force, elements):
        super().__init__()
        self.rod, self.elements = (k1, k2, gamma3, gamma1), elements
        self.F = self.define_global_parameter(F=force)

    def define_problem(self):
        k1, *_, gamma1 = self.rod
        self.add_mesh(LineMesh(N=self.elements))
        clamp = DirichletBC(px=0, py=0, theta=0) @ "left"
        load = (Follower(self.F, gamma1) + IntegralObservables(tip=var("py"))) @ "right"
        straight = InitialCondition(px=(1 - self.F / k1) * var("coordinate_x"))
        self.add_equations((Rod(*self.rod) + clamp + load + straight) @ "domain")


def near_onset(rod, force, omega, elements, steps, distance, folder):
    """Hopf point, and the orbit about this far from it: F_c, ω_c, A_tip²/(F − F_c), (ω − ω_c)/(F − F_c).

    On which side the branch lies is found by pyoomph. A_tip is the first harmonic of the tip.
    """
    problem = Flutter(*rod, force, elements)
    problem.set_output_directory(folder)
    problem.setup_for_stability_analysis(analytic_hessian=True)
    problem.initialise()
    problem.solve()
    values, vectors = problem.solve_eigenproblem(6, shift=1j * omega)
    i = int(np.argmin(np.abs(values - 1j * omega)))
    problem.activate_bifurcation_tracking(problem.F, "hopf", eigenvector=vectors[i], omega=values[i].imag)
    problem.solve()
    F_c, omega_c = problem.F.value, problem.get_last_eigenvalues()[0].imag
    # Splines in time: collocation at Gauss points loses its order to the stiff modes.
    with problem.switch_to_hopf_orbit(dparam=distance, NT=steps, mode="bspline", order=3) as orbit:
        tip = problem.get_mesh("domain/right")
        samples = [
            float(tip.evaluate_observable("tip"))
            for _ in orbit.iterate_over_samples(N=SAMPLES, endpoint=False)
        ]
        rate = 2 * np.pi / float(orbit.get_T(dimensional=False)) - omega_c
    detuning = problem.F.value - F_c
    amplitude = 2 * abs(np.fft.rfft(samples)[1]) / SAMPLES
    return np.array([F_c, omega_c, amplitude**2 / detuning, rate / detuning])


def analyse(k1, k2, gamma3, gamma1, force, omega, elements, steps, distance):
    """Both slopes extrapolated to onset from two orbits."""
    rod = k1, k2, gamma3, gamma1
    with tempfile.TemporaryDirectory() as folder:
        near, far = (
            near_onset(rod, force, omega, elements, steps, d, folder) for d in (distance, 2 * distance)
        )
    F_c, omega_c, A_tip2_slope, omega_slope = map(float, 2 * near - far)
    return {"force": F_c, "omega": omega_c, "A_tip2_slope": A_tip2_slope, "omega_slope": omega_slope}


if __name__ == "__main__":
    begin = time.perf_counter()
    answer = analyse(**json.loads(sys.argv[1]))
    print(json.dumps({**answer, "seconds": time.perf_counter() - begin}))
