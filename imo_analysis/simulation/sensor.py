"""What a converter makes of a current."""

from math import floor


def quantised(value, step):
    """The nearest multiple of ``step``."""
    return step * floor(value / step + 0.5)
