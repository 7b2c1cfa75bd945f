"""The audit: every statement of the paper as a `Claim`, settled by exact kernels into an `Entry` with a computed verdict.

How to add a claim: in a module of ``ledger/claims/`` (listed in ``claims/__init__.py``), append to its ``CLAIMS``::

    Claim(id="eq12.row2", item="(12)", title="rate of the q-axis current error", expected=Verdict.CORRECTED,
          setting=errors(),                  # names that stand for something: traced from equations/, see `settings`
          printed="i_qs_tilde_dot = ...",    # as printed, in Python syntax over the names of the notation table
          corrected="i_qs_tilde_dot = ...",  # after the smallest edit
          edit="...", origin="paper", why="...", consequences=("eq14",))

A name that the setting defines (``i_qs_tilde_dot``, ``omega_hat``) is replaced by its definition; every other name is a free
real variable. The statement is then an identity in rational functions: points in exact fractions look for a counterexample,
and the kernels confirm either the counterexample or the identity. The verdict follows from what was confirmed:

======================================  ==========================
printed formulas true                   holds
refuted, corrected formulas true        holds after correction
refuted, no correction                  fails
no formula, or readings that disagree   not determined by the text
======================================  ==========================

``expected`` is compared with that; a difference is an error. An inequality ``a <= b`` needs ``squares``: pairs of texts
(weight, base) with b - a = sum of weight * base**2, each weight >= 0 by the hypotheses of the setting. Statements that are
not formulas use ``prose`` and ``checks``: `Algebra` (formulas with a role and possibly a setting of their own) and
`Computed` (a function that returns whether it passed, and what it found).

`book.entries()` settles all claims; `mutants` tries every single slip of what is true, `definition_mutants` every
single-token fault of the definitions against `complex_forms`; `quadratic.squares_of` finds certificates; `audit` is for an
observer of your own, with ``subjects/kubota.py`` as the worked example.
"""
