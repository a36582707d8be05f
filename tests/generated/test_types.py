"""Every emitted function runs on every number type and gives the same number."""

import importlib
import inspect

import flint
import mpmath
import numpy as np
import pytest

MODULES = ("rod", "eigenproblem", "second_order", "third_order", "landau", "predictions")
FUNCTIONS = [
    pytest.param(f, id=f"{name}.{f.__name__}")
    for name in MODULES
    for f in vars(importlib.import_module(f"generated.follower.{name}")).values()
    if inspect.isfunction(f)
]


class Balls:
    """python-flint's namespace."""

    sin, cos, sqrt = staticmethod(flint.acb.sin), staticmethod(flint.acb.cos), staticmethod(flint.acb.sqrt)


def arguments(f, rng):
    """Generic values, away from zero: complex for fields, positive reals for parameters."""
    real = {"k1", "k2", "gamma1", "gamma3", "force", "u"}
    names = [n for n in inspect.signature(f).parameters if n != "xp"]
    return {n: (rng.integers(1, 64) + (0 if n in real else 1j) * rng.integers(1, 64)) / 16 for n in names}


def call(f, xp, values):
    namespace = {"xp": xp} if "xp" in inspect.signature(f).parameters else {}
    result = f(**namespace, **values)
    return result if isinstance(result, tuple) else (result,)


@pytest.mark.parametrize("f", FUNCTIONS)
def test_same_number_from_every_type(f):
    values = arguments(f, np.random.default_rng(7))
    with mpmath.workdps(30):
        reference = call(f, mpmath.mp, {n: mpmath.mpmathify(complex(v)) for n, v in values.items()})
        arrays = call(f, np, {n: np.full((3, 2), v) for n, v in values.items()})
        balls = call(f, Balls, {n: flint.acb(complex(v)) for n, v in values.items()})
        for exact, array, ball in zip(reference, arrays, balls, strict=True):
            assert np.allclose(np.asarray(array), complex(exact), rtol=1e-13)
            assert abs(complex(flint.acb(ball)) - complex(exact)) <= 1e-12 * abs(complex(exact))


@pytest.mark.parametrize("f", FUNCTIONS)
def test_broadcasts_over_rods_and_nodes(f):
    rng = np.random.default_rng(3)
    values = arguments(f, rng)
    nodes = [n for n in values if f.__doc__ and f"{n} (..., nodes)" in f.__doc__]
    rods = {n: np.array([[v], [2 * v]]) for n, v in values.items() if n not in nodes}
    shapes = {n: np.full((1, 5), v) for n, v in values.items() if n in nodes}
    for result in call(f, np, {**rods, **shapes}):
        assert np.broadcast_shapes(np.shape(result), (2, 5)) == (2, 5)


def test_modules_import_nothing():
    for name in MODULES:
        source = inspect.getsource(importlib.import_module(f"generated.follower.{name}"))
        assert "import" not in source.split('"""')[2]
