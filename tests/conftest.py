"""Settings for all tests."""

import os

import hypothesis

# Before NumPy is first imported: with the small matrices of these tests a second BLAS thread only costs.
for variable in ("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS"):
    os.environ.setdefault(variable, "1")

# A loaded machine is not a defect: no time limit for one example.
hypothesis.settings.register_profile("project", deadline=None)
hypothesis.settings.load_profile("project")
