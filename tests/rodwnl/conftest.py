"""Rods from files that several test modules share."""

import pytest

from rodwnl.models import emitted
from rodwnl.parameters import RodParameters

SPRING = """
name = "sprung"
title = "follower load, with a spring that holds the tip's angle or pushes it"
energy = "k1*(h1 - 1)^2/2 + k2*h2^2/2 + Pi^2/2"

[parameters]
kappa = { default = "1", meaning = "stiffness of the spring" }

[drag]
v1 = "gamma1"
v2 = "1"
Omega = "gamma3"

[[load]]
kind = "follower"

[[load]]
kind = "spring"
stiffness = "kappa"
"""


@pytest.fixture(scope="session")
def sprung(tmp_path_factory):
    """The plain rod with a spring of this stiffness at its tip."""
    folder = tmp_path_factory.mktemp("sprung")
    (folder / "rod.toml").write_text(SPRING)
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("RODWNL_CACHE", str(folder / "cache"))
        model = emitted(str(folder / "rod.toml"))
    return lambda values, kappa: RodParameters(*values, model=model, kappa=kappa)
