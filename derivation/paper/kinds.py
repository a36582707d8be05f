"""What kind of equation it is: what it may be decided by, whether it is a premise, where it belongs."""

from __future__ import annotations

from derivation.paper.algebra import constant
from derivation.paper.letters import SHAPES
from derivation.paper.lower import Lowering
from derivation.paper.meanings import FIELDS, LOADS, STRAINS, STRESSES, VELOCITIES
from derivation.paper.notation import Notation
from derivation.paper.syntax import Apply, Equation, Num, Prime, Relation, Sym, Tuple, walk
from derivation.paper.theory import Theory


def is_identity(low: Lowering) -> bool:
    """A strain or velocity of some order alone on the left: a kinematic expansion, for generic fields."""
    body = low.equation.body
    if not (isinstance(body, Relation) and isinstance(body.left, Sym) and body.left.order):
        return False
    if low.names & set(STRESSES):  # a balance law whose drag coefficient is 1
        return False
    if low.names & {"A", "H", *SHAPES}:  # the wave of the ansatz
        return False
    return low.notation.quantity(body.left.name) in (*STRAINS, *VELOCITIES)


def is_kinematic(low: Lowering) -> bool:
    """An identity, or one rearranged: strains, velocities and fields of some order, and nu alone."""
    if is_identity(low):
        return True
    ordered = {name for name, order in low.quantities if order}
    motions = {*STRAINS, *VELOCITIES}
    return (
        isinstance(low.equation.body, Relation)
        and low.place is None
        and bool(ordered & motions and ordered & set(FIELDS))
        and low.names <= {*motions, *FIELDS, "nu", "u", "tau", "T", "gamma2_dim", "k3_dim"}
    )


def states_solution(low: Lowering) -> bool:
    """A field of some order on its own on the left, everywhere: the solution at that order."""
    body = low.equation.body
    if not isinstance(body, Relation) or low.place is not None:
        return False
    head = body.left.fn if isinstance(body.left, Apply) else body.left
    right = {low.notation.quantity(s.name) for s in walk(body.right) if isinstance(s, Sym)}
    return (
        isinstance(head, Sym)
        and bool(head.order)
        and low.notation.quantity(head.name) in FIELDS
        and not right & set(FIELDS)
    )


def order_of(low: Lowering) -> int:
    """The highest order that occurs."""
    orders = [int(o) if o.isdigit() else low.indices.get(o, 0) for _, o in low.quantities if o]
    return max(orders, default=0)


_STARTS = {
    **dict.fromkeys(("r", "e1", "e2"), "configuration of the rod"),
    **dict.fromkeys(("r_free", "e1_free", "e2_free"), "stress-free configuration"),
    **dict.fromkeys(("h1", "h2", "Pi", "v1", "v2", "Omega"), "definition of strains and velocities"),
    **dict.fromkeys(LOADS, "drag law of the rod"),
    "energy": "stored energy of the rod",
    "mu": "a name",
    "Gamma": "a name",
    "H": "a name",
    "any": "the expansion",
    "tau": "the two times",
    "T": "the two times",
    "A": "polar form of the amplitude",
}


def premise_of(low: Lowering) -> str:
    """Why an equation that holds is a premise; empty when it follows from others."""
    body = low.equation.body
    if not isinstance(body, Relation):
        return ""
    names = low.names
    head = body.left.fn if isinstance(body.left, Apply) else body.left
    evaluated = isinstance(body.left, Apply) and any(
        not isinstance(a, Sym) or low.notation.quantity(a.name) == "length" for a in body.left.args
    )
    bare = not isinstance(head, Prime) and low.place is None and not evaluated
    while isinstance(head, Prime):
        head = head.arg
    quantity = low.notation.quantity(head.name) if isinstance(head, Sym) else None
    ordered = isinstance(head, Sym) and bool(head.order)
    if isinstance(body.left, Tuple):
        return "the inner product" if body.left.weight is not None and "Phi" in names else ""
    if quantity in ("force", "force_dim") and "Delta" in names:
        return "the scaling of the force"
    if quantity in ("k1", "k2", "gamma1", "gamma3", "force"):
        return "" if low.equation.label.startswith("tab:") else "a dimensionless parameter"
    if quantity in FIELDS and ordered and isinstance(head, Sym) and head.order == "1" and low.place is None:
        return "" if evaluated else "the ansatz"
    defining = bare and all(s != head for s in walk(body.right)) and not isinstance(body.right, Num)
    if quantity in _STARTS and not ordered and defining:
        return _STARTS[quantity]
    if not any(order for _, order in low.quantities):
        if quantity in (*FIELDS, *STRESSES) and isinstance(body.left, Apply) and "R_star" not in names:
            return "condition at an end of the rod"
        if names & set(LOADS):
            return "balance law"
    return ""


def is_choice(low: Lowering) -> bool:
    """The step of the difference quotient set equal to a number, which no theory prescribes."""
    body = low.equation.body
    if not isinstance(body, Relation) or not isinstance(body.right, Num):
        return False
    return low.names == {"delta", "force"} and low.value(body.left) == constant("step")


def grounds(low: Lowering) -> str:
    """What an equation that follows was reduced by."""
    n = order_of(low)
    if is_kinematic(low):
        return "identity for generic fields"
    if low.place is not None:
        return f"by the conditions at u = {low.place}"
    if n:
        return f"by the equations up to order {n}"
    return "by the equations it stands on"


GROUPS = ("exact rod", "order 1", "order 2", "order 3", "modes and adjoint", "amplitude")


def grouped(equation: Equation, notation: Notation, theory: Theory) -> str:
    """The part of the theory that an equation belongs to, one of :data:`GROUPS`."""
    low = Lowering(equation, notation, theory)
    order = max((int(o) for _, o in low.quantities if o.isdigit()), default=0)
    if low.names & {"R", "R_star", "sigma", "A_tip", "alpha", "beta", "lambda", "phase", "delta"}:
        return "amplitude"
    if order:
        return f"order {order}"
    if low.names & {"X0", "X2", "P0", "P2"}:
        return "order 2"
    if low.names & {"g1", "g2", "g3", "g4"}:
        return "order 3"
    if low.names & {"Y", "Theta", "H", "Psi", "Psi_Y", "Psi_Theta", "L", "weighted_L", "Gamma", "G"}:
        return "modes and adjoint"
    return "exact rod"


def stage_of(equation: Equation, notation: Notation, theory: Theory) -> str:
    """The module of the derivation that an equation's content comes from."""
    low = Lowering(equation, notation, theory)
    names, group = low.names, grouped(equation, notation, theory)
    if names & {"g1", "g2", "g3", "g4"} and names & {"alpha", "beta"}:
        return "derivation/solvability.py"
    if group == "amplitude":
        return "derivation/amplitude.py"
    if is_kinematic(low) or (group == "exact rod" and names & {"r", "e1", "e2"}):
        return "derivation/kinematics.py"
    if names & {"X0", "X2", "P0", "P2"} and not names & {"g1", "g3"}:
        return "derivation/corrections.py"
    if names & {"g1", "g2", "g3", "g4", "y_hat", "theta_hat"} or (
        order_of(low) == 3 and names & {"f2", "f3"}
    ):
        return "derivation/resonance.py"
    if names & {"Psi", "Psi_Y", "Psi_Theta"}:
        return "derivation/adjoint.py"
    if group.startswith("order"):
        return "derivation/hierarchy.py"
    return "derivation/harmonics.py" if group == "modes and adjoint" else "derivation/model.py"
