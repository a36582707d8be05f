"""Weakly nonlinear flutter of follower-force-driven Cosserat rods.

    from rodwnl import RodParameters, hopf_thresholds, landau

Public names are imported from their modules when first used, so that importing the package costs nothing.
"""

from importlib import import_module
from typing import TYPE_CHECKING

__version__ = "0.1.0"

if TYPE_CHECKING:
    from rodwnl.coefficients import landau as landau
    from rodwnl.errors import ComputationError as ComputationError
    from rodwnl.errors import InputError as InputError
    from rodwnl.parameters import RodParameters as RodParameters
    from rodwnl.predictions import predict as predict
    from rodwnl.spectrum import hopf_thresholds as hopf_thresholds

_HOME = {
    "ComputationError": "rodwnl.errors",
    "InputError": "rodwnl.errors",
    "RodParameters": "rodwnl.parameters",
    "hopf_thresholds": "rodwnl.spectrum",
    "landau": "rodwnl.coefficients",
    "predict": "rodwnl.predictions",
}

__all__ = [*_HOME, "__version__"]


def __getattr__(name: str) -> object:
    if name not in _HOME:
        raise AttributeError(f"module 'rodwnl' has no attribute {name!r}; it has {', '.join(__all__)}")
    return getattr(import_module(_HOME[name]), name)


def __dir__() -> list[str]:
    return __all__
