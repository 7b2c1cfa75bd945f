"""One chapter of the dossier a file; each takes data and gives a `Chapter`."""
