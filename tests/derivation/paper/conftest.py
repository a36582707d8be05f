"""The derivation, the notation and the bundled equations, made once."""

from __future__ import annotations

from pathlib import Path

import pytest

import derivation.paper
from derivation.paper.notation import Notation, load
from derivation.paper.read import Paper, read
from derivation.paper.theory import Theory
from derivation.pipeline import derive

BUNDLED = Path(derivation.paper.__file__).with_name("equations.tex")


@pytest.fixture(scope="session")
def notation() -> Notation:
    return load()


@pytest.fixture(scope="session")
def theory() -> Theory:
    return Theory(derive())


@pytest.fixture(scope="session")
def paper(notation) -> Paper:
    return read(BUNDLED.read_text(encoding="utf-8"), notation)
