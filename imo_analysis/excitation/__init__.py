"""Excitation and identifiability: Gram matrices along runs and in closed form, observability, resting states."""
