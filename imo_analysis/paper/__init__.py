"""What the paper prints, as data: `equations` (1)-(23), `tables` I-III, `statements` (lemmas, propositions, claims in the text)."""
