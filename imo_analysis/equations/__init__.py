"""The definitions: every equation once, as a plain function of real d/q scalars, tuples in and a tuple out.

The same function objects are fed symbols by the ledger and the pencils, and compiled by the simulator. They use only
``+ - * /``, integer powers and ``abs``, so that they run unchanged on floats, arrays, ring elements and symbols.

Arguments of one name mean the same everywhere: ``x`` the state, ``i`` and ``u`` current and voltage as d/q pairs, ``p`` the
parameters and ``gains`` the gains, in the order that the docstring or `catalogue.OBSERVERS` gives, ``direction`` the sign of
the speed. A pair has the name of its letter: ``z_hat`` is ``(z_1_hat, z_2_hat)``; ``z_feedback`` is what the z rows get fed
back.
"""
