"""The derivation of the paper's rod, made once."""

import pytest

from derivation.pipeline import Derivation, derive


@pytest.fixture(scope="session")
def follower() -> Derivation:
    return derive()
