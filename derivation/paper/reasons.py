"""Why an equation is not verified: raised where the reason is seen, told by the ledger."""

from __future__ import annotations


class UndecidedError(Exception):
    """An expression has no meaning here, or no rule for it; the message is the ledger's reason."""


class UnfitError(Exception):
    """The letters are known, but they do not go together: a vector set equal to a number."""
