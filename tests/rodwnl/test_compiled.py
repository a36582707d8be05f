"""Formulas of many rods as compiled C, against the same formulas in NumPy."""

import shutil
import subprocess

import numpy as np
import pytest

from rodwnl import batch, batch_problem, compiled, landau_batch
from rodwnl.batch_characteristic import along, jet, problem_with_slopes
from rodwnl.batch_problem import problem
from rodwnl.batch_rods import Rods
from rodwnl.recorded import Recorded, Tape

from .agreement import NUMBERS

needs_compiler = pytest.mark.skipif(shutil.which("cc") is None, reason="there is no C compiler")


@pytest.fixture(scope="module")
def shared(tmp_path_factory):
    return tmp_path_factory.mktemp("compiled")


@pytest.fixture
def once(monkeypatch, shared):
    """What tests of this module have compiled is kept for the others."""
    _compile_to(shared, monkeypatch)


@pytest.fixture
def fresh(monkeypatch, tmp_path):
    """Nothing compiled yet, and a folder of its own for what will be."""
    _compile_to(tmp_path, monkeypatch)
    return tmp_path


def _compile_to(folder, monkeypatch):
    monkeypatch.setenv("RODWNL_CACHE", str(folder))
    monkeypatch.delenv("RODWNL_CC", raising=False)
    monkeypatch.delenv("CC", raising=False)
    monkeypatch.setattr(batch_problem, "_kernels", {})


def rods(model, count=300, seed=3, **own):
    rng = np.random.default_rng(seed)
    values = {
        "k1": 10 ** rng.uniform(1.5, 6, count),
        "k2": 10 ** rng.uniform(1, 6, count),
        "gamma3": 10 ** rng.uniform(-6, 0, count),
        "gamma1": rng.uniform(0.2, 1, count),
    }
    return Rods(model, values | {name: rng.uniform(*limits, count) for name, limits in own.items()})


def formula(z, a):
    """Every operation that a number can record; of z in all four quadrants and real a."""
    root = np.sqrt(z)
    side = ((np.conj(z) * root).real > 0) - 0.5
    return (
        3 * root - z / (a + 2j) + 1 / z,
        np.exp(-root) * side - (1 - a * z) * np.exp(1j * a),
        a - (-z) * z.imag + (z * z) * 0 + 1 * z,
    )


@needs_compiler
def test_recorded_numbers_do_what_numpy_does(once):
    rng = np.random.default_rng(0)
    z = rng.normal(size=(3, 600)) + 1j * rng.normal(size=(3, 600))
    z[0, :4] = [1e-9j, -1e-9j, -2 + 1e-300j, 5]
    a = rng.uniform(1, 2, 600)
    tape = Tape()
    results = formula(Recorded(tape, "lam_re", "lam_im"), Recorded(tape, "a"))
    found = compiled.kernel(tape, ["a"], results)([a], z)
    for got, expected in zip(found, formula(z, a), strict=True):
        np.testing.assert_allclose(got, expected, rtol=1e-14, atol=1e-15)
    with pytest.raises(ValueError, match="2 columns for a formula of 1"):
        compiled.kernel(tape, ["a"], results)([a, a], z)


@needs_compiler
@pytest.mark.parametrize(
    ("model", "own"),
    [
        ("follower", {}),
        ("quartic", {"stretch4": (0, 300), "bend4": (0, 1)}),
        ("partial_follower", {"chi": (0.3, 1.1)}),
        ("sprung", {"kappa": (-0.5, 5)}),
    ],
)
def test_compiled_formulas_are_those_of_numpy(once, sprung, model, own):
    plain = rods(sprung(("200", "1e4", "1e-4"), 1).model if model == "sprung" else model, **own)
    many = Rods(plain.model, plain.values, compiled=True)
    force = np.minimum(plain.values["k1"], 400) * np.linspace(0.05, 0.95, len(plain))
    lam = np.linspace(-5, 5, len(plain)) + 1j * np.linspace(1, 300, 11)[:, None]
    expected = along(problem(plain.at(force)), lam)
    for got, value in zip(along(problem(plain.at(force), compiled=True), lam), expected, strict=True):
        np.testing.assert_allclose(got, value, atol=1e-12 * np.abs(value).max(), rtol=1e-9)
    slopes = jet(problem_with_slopes(plain, force), lam[4])
    for got, value in zip(jet(problem_with_slopes(many, force), lam[4]), slopes, strict=True):
        np.testing.assert_allclose(got, value, atol=1e-12 * np.abs(value).max(), rtol=1e-9)
    assert len(batch_problem._kernels) == 2
    assert all(batch_problem._kernels.values())  # both were compiled


@needs_compiler
def test_compiled_numbers_do_not_depend_on_the_rods_beside(once):
    """To the last bit: lanes of a vector register and the rest of a loop do the same."""
    many = Rods("follower", rods("follower").values, compiled=True)
    force, lam = np.minimum(many.values["k1"], 400) / 3, 3 + 200j * np.ones(len(many))
    whole = np.array(jet(problem_with_slopes(many, force), lam))
    for some in (slice(0, 1), slice(5, 18), np.array([299, 4, 77])):
        assert np.array_equal(jet(problem_with_slopes(many[some], force[some]), lam[some]), whole[:, some])


def assert_same(found, expected):
    assert np.array_equal(found.status, expected.status)
    assert np.array_equal(found.count, expected.count)
    assert np.array_equal(found.crossing, expected.crossing)
    for name in (*NUMBERS, "buckling_force"):
        np.testing.assert_allclose(getattr(found, name), getattr(expected, name), rtol=1e-9)


@needs_compiler
@pytest.mark.parametrize("model", ["follower", "partial_follower"])
def test_a_batch_is_the_same_either_way(once, monkeypatch, model):
    values = rods(model, 200).values
    expected = landau_batch(**values, model=model)
    assert not batch_problem._kernels  # so few are not worth it
    monkeypatch.setattr(batch, "COMPILED_FROM", 1)
    assert_same(landau_batch(**values, model=model), expected)
    assert len(batch_problem._kernels) >= 2
    assert all(batch_problem._kernels.values())


@pytest.mark.parametrize("compiler", ["", "no-such-compiler", "false", "'unended"])
def test_without_a_compiler_numpy_serves(fresh, monkeypatch, compiler):
    expected = landau_batch(200, 1e4, 1e-4)
    monkeypatch.setenv("RODWNL_CC", compiler)
    monkeypatch.setattr(batch, "COMPILED_FROM", 1)
    assert_same(landau_batch(200, 1e4, 1e-4), expected)
    assert not list(fresh.glob("compiled/*"))


def exponential():
    tape = Tape()
    return compiled.kernel(tape, [], [Recorded(tape, "lam_re", "lam_im").exp()])


@needs_compiler
def test_what_is_compiled_is_kept_and_mended(fresh, monkeypatch):
    z = np.array([[1 + 2j, 3j]])
    assert exponential()([], z)[0] == pytest.approx(np.exp(z))
    (kept,) = (fresh / "compiled").iterdir()
    with monkeypatch.context() as patch:
        patch.setattr(subprocess, "run", None)
        assert exponential()([], z)[0] == pytest.approx(np.exp(z))
    damaged = fresh / "other" / "compiled" / kept.name
    damaged.parent.mkdir(parents=True)
    damaged.write_text("no library", encoding="ascii")
    monkeypatch.setenv("RODWNL_CACHE", str(fresh / "other"))
    assert exponential()([], z)[0] == pytest.approx(np.exp(z))
    assert damaged.stat().st_size > 1000


@needs_compiler
def test_a_cache_that_cannot_be_written_is_done_without(fresh, monkeypatch):
    (fresh / "compiled").write_text("a file where the folder should be", encoding="ascii")
    assert exponential()([], np.array([[0j]]))[0, 0] == 1
