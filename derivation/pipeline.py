"""The front door: a rod goes in, its weakly nonlinear theory comes out, one line a stage."""

from __future__ import annotations

from dataclasses import dataclass

from derivation.adjoint import Adjoint, adjoint_problem
from derivation.amplitude import Amplitude, amplitude_equations
from derivation.constitutive import Constitution, expand_model
from derivation.corrections import SecondOrder, second_order
from derivation.eigenproblem import Eigenproblem, eigenproblem
from derivation.harmonics import Modes, first_order
from derivation.hierarchy import Hierarchy, build_hierarchy
from derivation.kinematics import ExactKinematics, ExpandedKinematics, exact_kinematics, expand_kinematics
from derivation.model import FOLLOWER, RodModel
from derivation.resonance import ThirdOrder, third_order
from derivation.solvability import LandauCoefficients, solvability


@dataclass(frozen=True)
class Derivation:
    """Every stage's record, in the order in which they were made.

    ``eigenproblem`` is None where the straight rod is not uniform: its modes are no exponentials.
    """

    model: RodModel
    law: Constitution
    exact: ExactKinematics
    kinematics: ExpandedKinematics
    hierarchy: Hierarchy
    modes: Modes
    second: SecondOrder
    third: ThirdOrder
    adjoint: Adjoint
    landau: LandauCoefficients
    eigenproblem: Eigenproblem | None
    amplitude: Amplitude


def derive(model: RodModel = FOLLOWER, order: int = 3) -> Derivation:
    """From the exact kinematics to the Stuart-Landau coefficients.

    Args:
        model: the rod.
        order: highest power of epsilon; 3 gives the cubic amplitude equation.

    Raises:
        ValueError: if ``order`` is not 3.
        ArithmeticError: if the model breaks an assumption of the theory; the message says where.
    """
    if order != 3:
        raise ValueError(f"order = {order}: the amplitude equation is derived at order 3")
    law = expand_model(model, order)
    exact = exact_kinematics()
    kinematics = expand_kinematics(exact, law, order)
    hierarchy = build_hierarchy(model, law, kinematics)
    modes = first_order(hierarchy)
    second = second_order(hierarchy, modes)
    third = third_order(hierarchy, second)
    adjoint = adjoint_problem(hierarchy, second.modes)
    landau = solvability(hierarchy, third, adjoint)
    exponentials = eigenproblem(hierarchy, adjoint) if law.uniform else None
    amplitude = amplitude_equations()
    return Derivation(
        model,
        law,
        exact,
        kinematics,
        hierarchy,
        modes,
        second,
        third,
        adjoint,
        landau,
        exponentials,
        amplitude,
    )
