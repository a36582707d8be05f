"""The two kinds of failure a caller can meet; the command line prints either as one line, exit code 2."""


class InputError(ValueError):
    """What was asked for is not allowed; the message names what was given, what is allowed and what to do."""


class ComputationError(RuntimeError):
    """What was asked for is allowed but could not be computed; the message says why and what may help."""


def shown(text: str) -> str:
    """A text from outside as it may be printed: what would act on a terminal is escaped."""
    return "".join(c if c.isprintable() else ascii(c)[1:-1] for c in text)
