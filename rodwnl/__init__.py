"""Weakly nonlinear flutter of follower-force-driven Cosserat rods.

    from rodwnl import RodParameters, hopf_thresholds, landau

Public names are imported from their modules when first used, so that importing the package costs nothing.
"""

from importlib import import_module
from typing import TYPE_CHECKING

__version__ = "0.1.0"

if TYPE_CHECKING:
    from rodwnl.batch import landau_batch as landau_batch
    from rodwnl.branches import branch as branch
    from rodwnl.coefficients import landau as landau
    from rodwnl.coexistence import bistability as bistability
    from rodwnl.coexistence import periodic_orbits as periodic_orbits
    from rodwnl.errors import ComputationError as ComputationError
    from rodwnl.errors import InputError as InputError
    from rodwnl.parameters import RodParameters as RodParameters
    from rodwnl.predictions import predict as predict
    from rodwnl.predictions import predict_buckled as predict_buckled
    from rodwnl.reduced import reduced_model as reduced_model
    from rodwnl.responses import amplitude_equation as amplitude_equation
    from rodwnl.responses import pitchfork as pitchfork
    from rodwnl.simulation import simulate as simulate
    from rodwnl.spectrum import hopf_thresholds as hopf_thresholds

_HOME = {
    "ComputationError": "rodwnl.errors",
    "InputError": "rodwnl.errors",
    "RodParameters": "rodwnl.parameters",
    "amplitude_equation": "rodwnl.responses",
    "bistability": "rodwnl.coexistence",
    "branch": "rodwnl.branches",
    "hopf_thresholds": "rodwnl.spectrum",
    "landau": "rodwnl.coefficients",
    "landau_batch": "rodwnl.batch",
    "periodic_orbits": "rodwnl.coexistence",
    "pitchfork": "rodwnl.responses",
    "predict": "rodwnl.predictions",
    "predict_buckled": "rodwnl.predictions",
    "reduced_model": "rodwnl.reduced",
    "simulate": "rodwnl.simulation",
}

__all__ = [*_HOME, "__version__"]


def __getattr__(name: str) -> object:
    if name not in _HOME:
        raise AttributeError(f"module 'rodwnl' has no attribute {name!r}; it has {', '.join(__all__)}")
    return getattr(import_module(_HOME[name]), name)


def __dir__() -> list[str]:
    return __all__
