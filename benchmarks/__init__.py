"""How fast the simulator is, beside hand-written C and the usual Python ways: ``python -m benchmarks``."""
