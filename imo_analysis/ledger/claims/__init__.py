"""The claims of the paper, one module a topic; each has ``CLAIMS``, a list in the paper's order (see `imo_analysis.ledger`)."""

# In the paper's order; the repairs, which are ours, come last.
MODULES: tuple[str, ...] = (
    "model",
    "observer",
    "adaptation",
    "error_dynamics",
    "derivative",
    "stability",
    "excitation",
    "simulation",
    "repairs",
    "conserved",
    "closed_forms",
    "operating_lines",
    "resting",
    "noise",
    "supervisor",
    "scheduled",
    "resistance",
    "printed_poles",
)
