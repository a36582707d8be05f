"""Weakly nonlinear flutter of follower-force-driven Cosserat rods.

    from rodwnl import RodParameters, hopf_thresholds, landau

Public names are imported from their modules when first used, so that importing the package costs nothing.
"""

from importlib import import_module
from typing import TYPE_CHECKING

__version__ = "0.1.0"

if TYPE_CHECKING:
    from rodwnl.errors import ComputationError as ComputationError
    from rodwnl.errors import InputError as InputError
    from rodwnl.parameters import RodParameters as RodParameters

_HOME = {
    "ComputationError": "rodwnl.errors",
    "InputError": "rodwnl.errors",
    "RodParameters": "rodwnl.parameters",
}

__all__ = ["ComputationError", "InputError", "RodParameters", "__version__"]


def __getattr__(name: str) -> object:
    if name not in _HOME:
        raise AttributeError(f"module 'rodwnl' has no attribute {name!r}; it has {', '.join(__all__)}")
    return getattr(import_module(_HOME[name]), name)


def __dir__() -> list[str]:
    return __all__
