"""Other observers, audited whole through `imo_analysis.ledger.audit`: examples of how to bring one's own."""
