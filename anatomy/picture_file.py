"""Writes pictures as .png or .svg, without the date and the version of matplotlib."""

import matplotlib
from matplotlib import pyplot as plt

from common.errors import InputError
from common.files import replacing

matplotlib.use("Agg")  # needs no display
# None leaves an entry out. With a date or a version of matplotlib, equal pictures would differ in their bytes.
METADATA = {".png": {"Software": None}, ".svg": {"Date": None}}


def check_format(out):
    """Raises InputError if the pathlib path `out` of a picture ends neither in .png nor in .svg."""
    if out.suffix not in METADATA:
        raise InputError("unknown picture format", out, out.suffix, "name a .png or .svg file")


def save(figure, out, dpi=110):
    """Writes a matplotlib figure to the path `out`, at dpi dots per inch, and closes it."""
    with replacing(out) as partial:
        figure.savefig(partial, dpi=dpi, metadata=METADATA[out.suffix])
    plt.close(figure)
