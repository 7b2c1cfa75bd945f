"""Observers over recorded logs: reading, checking, estimating, and saying how well it went."""
