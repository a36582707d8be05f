import subprocess
import sys

import pytest

import rodwnl


@pytest.mark.parametrize("name", rodwnl.__all__)
def test_every_public_name_is_there(name):
    assert getattr(rodwnl, name) is not None


def test_an_unknown_name_lists_the_known_ones():
    with pytest.raises(AttributeError, match=r"'landaus'.*RodParameters"):
        _ = rodwnl.landaus


def test_importing_the_package_imports_no_library():
    libraries = ["numpy", "scipy", "sympy", "typer", "rich"]
    code = f"import sys, rodwnl; print([m for m in {libraries} if m in sys.modules])"
    result = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert result.stdout.strip() == "[]"
