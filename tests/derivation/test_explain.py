"""The steps to a derived object: every object has them, in order, each once, ending with itself."""

import pytest

from derivation.catalogue import objects
from derivation.explain import SOURCES, THOUGHTS, explain, thoughts
from derivation.pipeline import derive


@pytest.fixture(scope="module")
def derivation():
    return derive()


def test_sources_are_derived_objects(derivation):
    known = objects(derivation)
    assert set(SOURCES) | {s for sources in SOURCES.values() for s in sources} <= set(known)


@pytest.mark.parametrize("name", ["h2_3", "balance_2", "X2", "g1", "g4", "alpha", "A_tip"])
def test_sources_come_first(name, derivation):
    names = [step.object.name for step in explain(name, derivation)]
    assert names[-1] == name
    assert len(set(names)) == len(names)
    for n in names:
        assert all(names.index(s) < names.index(n) for s in SOURCES.get(n, ()))


def test_every_step_says_how(derivation):
    assert [s.object.name for s in explain("A_tip", derivation) if not s.because] == []


def test_the_orders_that_meet(derivation):
    steps = {s.object.name: s.because for s in explain("balance_2", derivation)}
    assert "cos(0) x'(2), cos(2) x'(0), sin(1) y'(1)" in steps["h1_2"]
    assert "drag = F2(2)' + Pi(1) F1(1) + Pi(2) F1(0)" in steps["balance_2"]


def test_what_was_eliminated(derivation):
    *_, last = explain("g1", derivation)
    for name in ("Y_uu", "X0_u", "X2_uu"):
        assert name in last.because


@pytest.mark.parametrize("name", ["h2_3", "balance_2", "X2", "g1", "g4", "alpha", "alpha_kept", "A_tip"])
def test_thoughts_hold_every_step_once_and_none_before_its_sources(name, derivation):
    grouped = thoughts(name, derivation)
    names = [step.object.name for thought in grouped for step in thought.steps]
    assert sorted(names) == sorted(step.object.name for step in explain(name, derivation))
    assert names[-1] == name
    place = {step.object.name: k for k, thought in enumerate(grouped) for step in thought.steps}
    assert all(place[s] <= place[n] for n in names for s in SOURCES.get(n, ()) if s in place)


def test_the_cubic_forcing_takes_nine_thoughts(derivation):
    assert len(thoughts("g1", derivation)) == 9
    assert {n for _, names in THOUGHTS for n in names} <= set(objects(derivation))


def test_an_unknown_object(derivation):
    with pytest.raises(KeyError):
        explain("g5", derivation)
