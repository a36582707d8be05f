"""The front door: a rod goes in, its weakly nonlinear theory comes out, one line a stage."""

from __future__ import annotations

from dataclasses import dataclass

from derivation.adjoint import Adjoint, adjoint_problem
from derivation.amplitude import Amplitude, amplitude_equations
from derivation.anyorder import NormalForm, expand_normal_form, require_order
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
    ``pitchfork`` is None where no eigenvalue can pass through 0.
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
    normal_form: NormalForm
    pitchfork: NormalForm | None


def derive(model: RodModel = FOLLOWER, order: int = 3) -> Derivation:
    """From the exact kinematics to the coefficients of the amplitude equation.

    Args:
        model: the rod.
        order: highest power of epsilon, odd. The records up to ``landau`` are those of order 3, the paper's;
            ``normal_form`` holds the responses and coefficients through ``order``.

    Raises:
        ValueError: if ``order`` is even or less than 3.
        ModelError: if the model breaks an assumption of the theory; the message says which and where.
        ArithmeticError: if a check of the derivation fails.
    """
    require_order(order)
    law = expand_model(model, order)
    exact = exact_kinematics()
    kinematics = expand_kinematics(exact, law, 3)
    hierarchy = build_hierarchy(model, law, kinematics)
    modes = first_order(hierarchy)
    second = second_order(hierarchy, modes)
    third = third_order(hierarchy, second)
    adjoint = adjoint_problem(hierarchy, second.modes)
    landau = solvability(hierarchy, third, adjoint)
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
        eigenproblem(hierarchy, adjoint) if law.uniform else None,
        amplitude_equations(),
        expand_normal_form(exact, law, order),
        expand_normal_form(exact, law, 3, steady=True) if law.may_buckle else None,
    )
