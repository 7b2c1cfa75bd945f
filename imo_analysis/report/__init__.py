"""The dossier: figures, typeset mathematics and the pages of the report."""
