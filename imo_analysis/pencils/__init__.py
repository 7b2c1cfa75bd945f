"""Linearisations of the observers' error dynamics, their poles, and what is read from them.

``error`` has the pencils as `control.StateSpace`, ``settling`` the part of them that norms, Bode and margins need,
``operating`` the state where an observer with parameter errors rests, ``floquet`` the exponents where axes matter.
"""
