"""What a converter makes of a current."""

from math import floor


def quantised(value, step):
    """The multiple of ``step`` that is nearest to ``value``."""
    return step * floor(value / step + 0.5)
