"""Settings for all tests."""

import os

# Before NumPy is first imported: with the small matrices of these tests a second BLAS thread only costs.
for variable in ("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS"):
    os.environ.setdefault(variable, "1")
