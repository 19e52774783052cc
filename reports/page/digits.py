"""How the page writes numbers and labels: filters for the templates, and the number of decimals."""

import math

import jinja2

MISSING = "–"
MOST_DIGITS = 6  # decimals


def decimals(value, digits):
    """Number of decimals that show `value` with `digits` significant digits, at least 0. For zero: digits - 1."""
    return max(0, digits - 1 - math.floor(math.log10(abs(value)))) if value else digits - 1


def lower_first(text):
    """A label for use within a sentence: the first letter small, unless the first word is in capitals."""
    return text if text[:2].isupper() else text[0].lower() + text[1:]


def fixed(value, digits=2):
    """A number with `digits` decimals. A dash if the value is missing; a text is returned as it is."""
    if value is None or isinstance(value, jinja2.Undefined):
        return MISSING
    return value if isinstance(value, str) else f"{value:,.{digits}f}"


def signed(value, digits=2):
    """A difference with its sign and `digits` decimals; a dash if it is missing. The minus is the character U+2212."""
    if value is None:
        return MISSING
    text = f"{abs(value):.{digits}f}"
    if float(text) == 0.0:
        return text
    return ("−" if value < 0 else "+") + text


def significant(value, digits=2):
    """A number with `digits` significant digits, never as a power of ten; a dash if it is missing."""
    return MISSING if value is None else f"{value:,.{decimals(value, digits)}f}"


def signed_significant(value, digits=2):
    """A difference with its sign and `digits` significant digits; a dash if it is missing."""
    return MISSING if value is None else signed(value, decimals(value, digits))


def enough_decimals(value, least):
    """Number of decimals: `least`, or more so that two significant digits of `value` are shown."""
    return max(least, min(MOST_DIGITS, decimals(value, 2) if value else 0))


def signed_decimals(value, least):
    """A difference with its sign, with `enough_decimals`; a dash if it is missing."""
    return MISSING if value is None else signed(value, enough_decimals(value, least))


def fixed_decimals(value, least):
    """A size such as a standard deviation, with `enough_decimals`; a dash if it is missing."""
    return MISSING if value is None else fixed(value, enough_decimals(value, least))


def scientific(value):
    """A small number, such as a residual, in the form 2.1e-06; a dash if it is missing."""
    return MISSING if value is None or isinstance(value, jinja2.Undefined) else f"{value:.1e}"


def percent(value, digits=1):
    """A number in per cent with `digits` decimals and the sign %; a dash if it is missing."""
    return MISSING if value is None else f"{value:.{digits}f} %"


FILTERS = {
    one.__name__: one
    for one in (
        lower_first,
        fixed,
        signed,
        significant,
        signed_significant,
        signed_decimals,
        fixed_decimals,
        scientific,
        percent,
    )
}
