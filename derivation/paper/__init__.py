"""A paper's equations: its LaTeX is read, and each equation is decided against the derivation.

``scan`` cuts the displays out of the source, ``tokens`` and ``parse`` turn an equation into the small
syntax tree of ``syntax``, ``lower`` gives it its meaning in the exact algebra, ``ledger`` decides it.
Nothing that is read is ever executed.
"""
