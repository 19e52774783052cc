"""Agreement of two methods on the same patients (Bland & Altman, Lancet 1986; 327: 307-310)."""

import dataclasses
import math

import numpy as np
from scipy.stats import t as student

from common.errors import InputError

# The limits of agreement lie this many standard deviations to either side of the bias. If the differences are normally
# distributed, 95 % of them lie between.
LIMIT_SD_FACTOR = 1.96
FEWEST_FOR_INTERVAL = 3  # patients


@dataclasses.dataclass(frozen=True)
class Agreement:
    """Differences a - b over n patients: mean (bias), sd, limits of agreement, confidence interval of the bias.

    sd_* and limits are None for n < 2, the interval for n < 3. mean_a, sd_a, mean_b and sd_b describe a and b alone.
    """

    n: int
    bias: float
    sd: float | None
    loa_lower: float | None
    loa_upper: float | None
    bias_ci_lower: float | None
    bias_ci_upper: float | None
    mean_a: float
    sd_a: float | None
    mean_b: float
    sd_b: float | None


def bland_altman(a, b):
    """Agreement of the paired values a and b, each (n,), n >= 1.

    sd is the sample standard deviation (n - 1). The limits of agreement are bias +- 1.96 sd. The bias has the 95 %
    confidence interval bias +- t(0.975, n - 1) sd / sqrt(n).
    Raises InputError for unpaired, missing or non-finite values.
    """
    a, b = np.asarray(a, float), np.asarray(b, float)
    if a.shape != b.shape or a.ndim != 1 or a.size == 0:
        raise InputError(
            "paired values are expected", "agreement", f"{a.shape} and {b.shape}", "give one of each a case"
        )
    if not (np.isfinite(a).all() and np.isfinite(b).all()):
        raise InputError("a value to compare is not a number", "agreement", "NaN", "repeat the case's metrics")
    n, bias = a.size, float(np.mean(a - b))
    sd = sample_sd(a - b)
    lower = upper = ci_lower = ci_upper = None
    if sd is not None:
        lower, upper = bias - LIMIT_SD_FACTOR * sd, bias + LIMIT_SD_FACTOR * sd
    if n >= FEWEST_FOR_INTERVAL:
        half = float(student.ppf(0.975, n - 1)) * sd / math.sqrt(n)
        ci_lower, ci_upper = bias - half, bias + half
    means = (float(a.mean()), sample_sd(a), float(b.mean()), sample_sd(b))
    return Agreement(n, bias, sd, lower, upper, ci_lower, ci_upper, *means)


def sample_sd(values):
    """Sample standard deviation of values (n,); None for a single value."""
    return float(np.std(values, ddof=1)) if len(values) > 1 else None
