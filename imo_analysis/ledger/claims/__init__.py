"""The claims of the paper, one module a topic; each has ``CLAIMS``, a list in the paper's order (see `imo_analysis.ledger`)."""

# In the paper's order.
MODULES: tuple[str, ...] = ("transformed_model", "error_dynamics")
