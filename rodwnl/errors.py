"""The two kinds of failure a caller can meet; the command line prints either as one line, exit code 2."""


class InputError(ValueError):
    """What was asked for is not allowed; the message names what was given, what is allowed and what to do."""


class ComputationError(RuntimeError):
    """What was asked for is allowed but could not be computed; the message says why and what may help."""
