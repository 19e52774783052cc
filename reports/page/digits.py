"""Number of decimals with which a number is shown."""

import math


def decimals(value, digits):
    """Decimals that show a number with `digits` significant digits; 0 for numbers that need none."""
    return max(0, digits - 1 - math.floor(math.log10(abs(value)))) if value else digits - 1
