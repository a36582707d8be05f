"""Settings for all tests."""

import os
import signal

import hypothesis

# Before NumPy is first imported: with the small matrices of these tests a second BLAS thread only costs.
for variable in ("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS"):
    os.environ.setdefault(variable, "1")

# A run in the background ignores Ctrl-C, and so would the commands that the tests start and interrupt.
signal.signal(signal.SIGINT, signal.default_int_handler)

# A loaded machine is not a defect: no time limit for one example.
hypothesis.settings.register_profile("project", deadline=None)
hypothesis.settings.load_profile("project")
