"""The rod for jaxcont (PyPI): Hopf point and first Lyapunov coefficient of the collocated equations.

    python jaxcont_rod.py '{"k1": 200, "k2": 1e4, "gamma3": 1e-4, "gamma1": 0.5, "force": 49.8, "degree": 24}'

`force` is where the search starts. Lengths in L, times in γ2 L⁴/k3. Prints one JSON object.
"""

import json
import sys
import time

import jax

jax.config.update("jax_enable_x64", True)

import jax.numpy as jnp  # noqa: E402
import numpy as np  # noqa: E402
from jaxcont.bifurcations.hopf_normal_form import hopf_point, lyapunov_coefficient  # noqa: E402
from numpy.polynomial import chebyshev  # noqa: E402


def differentiation(degree: int) -> tuple[np.ndarray, np.ndarray]:
    """Chebyshev–Lobatto points on [0, 1] and the matrix values -> derivatives."""
    t = -np.cos(np.pi * np.arange(degree + 1) / degree)
    series = np.linalg.inv(chebyshev.chebvander(t, degree))
    slopes = chebyshev.chebvander(t, degree - 1) @ chebyshev.chebder(np.eye(degree + 1))
    return (1 + t) / 2, 2 * slopes @ series


def rod(k1: float, k2: float, gamma3: float, gamma1: float, degree: int):
    """f(q, F) = q_t for q = (x, y, θ) at all points but the clamp, and the straight rod q(F).

    γ1 v1 = F1' − θ'F2, v2 = F2' + θ'F1, γ3 θ_t = θ'' + h1 F2 − h2 F1 with F1 = k1(h1 − 1), F2 = k2 h2; at the
    tip F1 = −F and F2 = θ' = 0 take the place of the computed stresses.
    """
    u, D = differentiation(degree)

    def f(q, F, args):
        x, y, theta = (jnp.concatenate([jnp.zeros(1, q.dtype), part]) for part in jnp.split(q, 3))
        c, s = jnp.cos(theta), jnp.sin(theta)
        h1, h2, bend = c * (D @ x) + s * (D @ y), -s * (D @ x) + c * (D @ y), D @ theta
        F1, F2 = (k1 * (h1 - 1)).at[-1].set(-F), (k2 * h2).at[-1].set(0.0)
        h1, h2, bend = 1 + F1 / k1, F2 / k2, bend.at[-1].set(0.0)
        v1, v2 = (D @ F1 - bend * F2) / gamma1, D @ F2 + bend * F1
        spin = (D @ bend + h1 * F2 - h2 * F1) / gamma3
        return jnp.concatenate([(c * v1 - s * v2)[1:], (s * v1 + c * v2)[1:], spin[1:]])

    def straight(F):
        return jnp.concatenate([(1 - F / k1) * jnp.asarray(u[1:]), jnp.zeros(2 * degree)])

    return f, straight


def analyse(k1: float, k2: float, gamma3: float, gamma1: float, force: float, degree: int) -> dict:
    f, straight = rod(k1, k2, gamma3, gamma1, degree)
    # The residual cannot fall below the round-off of second derivatives times the stiffness, so the tolerance
    # is wide; a second search, from where the first stopped, adds the Newton step that it saves.
    q, F = straight(force), force
    for _ in range(2):
        q, F, q1, q2, omega, converged = hopf_point(f, q, F, tol=1e-3, max_iter=30)
    l1 = lyapunov_coefficient(f, q, F, q1, q2, omega)

    def eigenvalues(F):
        return jnp.linalg.eigvals(jax.jacfwd(f)(straight(F), F, None))

    values, slopes = jax.jvp(eigenvalues, (F,), (jnp.ones(()),))
    beta = complex(slopes[jnp.argmin(jnp.abs(values - 1j * omega))])
    # With q = (q1 + i q2) w + c.c.: dw/dt = (iω + β δ) w + c1 w|w|². Here Re c1 = 2ω l1, because this l1 is
    # half of the Re c1/ω of its source (Kuznetsov). The tip moves by 2|w||q_tip|.
    tip = abs(complex(q1[2 * degree - 1], q2[2 * degree - 1]))
    return {
        "force": float(F),
        "omega": float(omega),
        "A_tip2_slope": float(4 * tip**2 * -beta.real / (2 * omega * l1)),
        "omega_slope": None,
        "converged": bool(converged),
    }


if __name__ == "__main__":
    request = json.loads(sys.argv[1])
    begin = time.perf_counter()
    answer = analyse(**request)
    print(json.dumps({**answer, "seconds": time.perf_counter() - begin}))
