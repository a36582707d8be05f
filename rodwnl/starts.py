"""A critical mode as a starting solution for software that continues boundary-value problems."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from rodwnl.collocated import nearest, pencil
from rodwnl.errors import InputError
from rodwnl.inverse import Real
from rodwnl.parameters import RodParameters
from rodwnl.spectrum import hopf_thresholds
from rodwnl.straightrod import parameter_values, straight_rod
from rodwnl.thresholds import nodes_at


@dataclass(frozen=True)
class ModeStart:
    """title: where the mode is. parameters: of the rod, with force and omega (and nu where it is one).

    table (N, 10): places on the rod, barycentric weights, then Y, H, Theta, Theta', real and imaginary. A nu
    that varies and is not explicit follows, (N, 11).
    """

    title: str
    parameters: dict[str, float]
    table: Real


def mode_start(rod: RodParameters, number: int = 1) -> ModeStart:
    """The mode at the rod's threshold of that number, counted from 1 by force, with Y(1) = 1.

    (Y, H, Θ, Θ') real and imaginary on Gauss–Legendre nodes: the polynomial through them is the mode to
    about the accuracy of the threshold. Raises InputError where there is no such threshold.
    """
    found = hopf_thresholds(rod)
    if not 1 <= number <= len(found):
        raise InputError(
            f"there is no Hopf threshold number {number}: this rod has {len(found)} "
            f"up to force {float(found.max_force):g}"
        )
    force, omega = found[number - 1].force, found[number - 1].omega
    straight, nodes = straight_rod(rod, force), nodes_at(rod, force, omega)
    p = pencil(straight, nodes)
    z = nearest(p, 1j * omega).right
    z = z / (p.fields.Y_tip @ z)
    shapes = [field @ z for field in (p.fields.Y, p.fields.H, p.fields.Theta, p.fields.Theta_u)]
    columns = [part for shape in shapes for part in (shape.real, shape.imag)]
    if straight.varies_implicitly:
        columns.append(straight.stretch(nodes.u)[0])
    # Barycentric weights of Gauss–Legendre nodes: Wang and Xiang, doi:10.1090/S0025-5718-2011-02549-4.
    weights = np.sqrt(nodes.u * (1 - nodes.u) * nodes.weights) * (-1.0) ** np.arange(len(nodes.u))
    values = parameter_values(rod) | {"force": force, "omega": omega}
    values |= {"nu": straight.values["nu"].real} if "nu" in straight.values else {}
    return ModeStart(
        f"Hopf threshold number {number}, force {force:.12g}, omega {omega:.12g}",
        {name: float(value) for name, value in values.items()},
        np.stack([nodes.u, weights, *columns], axis=1),
    )
