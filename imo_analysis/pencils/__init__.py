"""Frozen-speed and full linearisations of the observers' error dynamics, their poles, Table II, sweeps, maps and tuning."""
