"""Settings for all tests."""

import atexit
import importlib
import os
import pkgutil
import shutil
import signal
import tempfile

import hypothesis

# Before NumPy is first imported: with the small matrices of these tests a second BLAS thread only costs.
for variable in ("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS"):
    os.environ.setdefault(variable, "1")

# Rods from files and compiled formulas are kept for this run alone, and not in the user's cache folder.
# Workers inherit it.
if "RODWNL_CACHE" not in os.environ:
    os.environ["RODWNL_CACHE"] = tempfile.mkdtemp(prefix="rodwnl-tests-")
    atexit.register(shutil.rmtree, os.environ["RODWNL_CACHE"], ignore_errors=True)

# A run in the background ignores Ctrl-C, and so would the commands that the tests start and interrupt.
signal.signal(signal.SIGINT, signal.default_int_handler)

# Commands import what they use when they run. A module that is first imported while a test has replaced a
# name elsewhere would keep the replacement for the tests after it: all modules are imported before any test.
for package in map(importlib.import_module, ("rodwnl", "derivation")):
    for found in pkgutil.walk_packages(package.__path__, package.__name__ + "."):
        if not found.name.endswith("__main__"):
            importlib.import_module(found.name)

# A loaded machine is not a defect: no time limit for one example.
hypothesis.settings.register_profile("project", deadline=None)
hypothesis.settings.load_profile("project")
