"""The simulator: plant, drive and observers compiled from the one definition of each equation."""
