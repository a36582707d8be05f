"""What can be wrong with what a user hands to the derivation."""


class ReadError(ValueError):
    """A text cannot be read; the message gives its line and what was expected there."""

    def __init__(self, line: int, problem: str) -> None:
        super().__init__(f"line {line}: {problem}")
        self.line = line


class ModelError(ValueError):
    """A rod breaks an assumption of the theory; the message names the assumption and the place."""
