"""The law of any rod from its emitted functions: what its nonlinear dynamics are computed with.

`laws` holds the same by hand, for the independent route; nothing here uses that.
"""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

from rodwnl import kernels, nilpotent
from rodwnl.errors import InputError
from rodwnl.parameters import RodParameters
from rodwnl.straightrod import arguments, parameter_values
from rodwnl.strainform import RodLaw, Triple

FUNCTIONS = SimpleNamespace(
    **{name: getattr(nilpotent, name) for name in ("sin", "cos", "sqrt", "exp", "log")}
)


def emitted_law(rod: RodParameters) -> RodLaw:
    """The rod's stresses, drag and loads as a `RodLaw`, in units with γ2 = k3 = 1.

    Raises InputError for a rod with a load along it that is not along e1, which `strainform` does not hold.
    """
    functions = kernels.load(rod.model)
    values: dict[str, Any] = parameter_values(rod) | {"xp": FUNCTIONS}

    def call(name: str, **fields: Any) -> Triple:
        function, known = getattr(functions, name), values | fields
        first, second, third = function(*(known[argument] for argument in arguments(function)))
        return first, second, third

    _, across, moment = call("body_load", force=1.0)
    if across or moment:
        raise InputError(f"rod {rod.model_name!r}: a load along the rod must follow its tangent")

    return RodLaw(
        stress=lambda h1, h2, pi: call("stresses", h1=h1, h2=h2, Pi=pi),
        drag=lambda h1, h2, pi: call("drag_coefficients", h1=h1, h2=h2, Pi=pi),
        load=lambda theta, v, force: call("tip_load", theta=theta, v1=v[0], v2=v[1], Omega=v[2], force=force),
        body=lambda force: call("body_load", force=force)[0],
    )
