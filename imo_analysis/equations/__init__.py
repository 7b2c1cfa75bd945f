"""The definitions: every equation once, as a plain function of real d/q scalars, tuples in and a tuple out.

The same function objects are fed symbols by the ledger and the pencils, and compiled by the simulator. They use only
``+ - * /``, integer powers and ``abs``, so that they run unchanged on floats, arrays, ring elements and symbols.
"""
