"""A paper's equations: its LaTeX is read, and each equation is decided against the derivation.

``scan`` cuts the displays out of the source; ``tokens``, ``scripts``, ``pieces`` and ``parse`` make equations
of them, in the small syntax tree of ``syntax``. ``letters`` and ``lower`` give an equation its meaning in
the exact algebra (``algebra``) by what the derivation made (``meanings``); ``reduction`` reduces it by the
rules of ``theory``; ``ledger`` decides it. ``repair`` finds the edit that would make it true, ``chain`` what
the error would do, ``mutants`` whether errors are seen. Nothing that is read is ever executed.
"""
