"""Number of decimals with which a number is shown."""

import math


def decimals(value, digits):
    """Number of decimals that show `value` with `digits` significant digits, at least 0. For zero: digits - 1."""
    return max(0, digits - 1 - math.floor(math.log10(abs(value)))) if value else digits - 1
