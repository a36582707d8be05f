"""Gauss–Legendre nodes on [0, 1] with the matrix of the indefinite integral: every integral of the
float64 route.
"""

from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from numpy.polynomial.legendre import leggauss, legvander
from numpy.typing import NDArray

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Nodes:
    """u (N,): the nodes, increasing. weights (N,): ∫₀¹ f du = weights·f, exact for degree 2N − 1.
    from_clamp and to_tip (N, N): f -> ∫₀ᵘ f and ∫ᵤ¹ f at the nodes, exact for degree N − 1.
    """

    u: Array
    weights: Array
    from_clamp: Array
    to_tip: Array


@lru_cache(maxsize=32)
def gauss_legendre(count: int) -> Nodes:
    """`count` >= 1 nodes. The arrays are read-only: every caller gets the same ones.

    With f = Σ c_k P_k, c_k = (2k+1)/2 Σ_j w_j P_k(s_j) f(s_j) on [−1, 1], the integral follows from
    ∫₋₁ˢ P_k = (P_{k+1} − P_{k−1})/(2k+1) (DLMF 18.9.19 integrated, https://dlmf.nist.gov/18.9).
    """
    s, w = leggauss(count)
    legendre, k = legvander(s, count), np.arange(count)
    coefficients = (k[:, None] + 0.5) * legendre[:, :count].T * w
    antiderivative = np.empty((count, count))
    antiderivative[:, 0] = 1 + s
    antiderivative[:, 1:] = (legendre[:, 2:] - legendre[:, :-2]) / (2 * k[1:] + 1)
    from_clamp = antiderivative @ coefficients / 2
    nodes = Nodes((1 + s) / 2, w / 2, from_clamp, w / 2 - from_clamp)
    for array in (nodes.u, nodes.weights, nodes.from_clamp, nodes.to_tip):
        array.setflags(write=False)
    return nodes
