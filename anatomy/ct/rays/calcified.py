"""The lumen's edge inside bright plaque: blurred blood, a gap of soft wall and blurred calcium, fitted on each ray."""

import numpy as np

from .stented import disc

STEP_MM, NARROWEST_MM, WIDEST_MM = 0.05, 0.2, 3.2
GAPS_MM = (0.0, 0.15, 0.3, 0.45, 0.6, 0.8, 1.0)  # of soft wall between blood and calcium
THICK_MM = (0.3, 0.5, 0.75, 1.0, 1.4)  # of the calcium
DENSEST_HU = 1500.0  # coronary calcium in CT; denser and thinner sheets would look the same
TOGETHER = 1000  # rays fitted at a time, for the memory's sake


def fit(hu, r_mm, blood, tissue, sigma_mm):
    """Radii (n,) mm of rays hu (n, k) at r_mm (k,): least squares over (R, g, t, H) of

    I(r) = T + (B - T) disc(r; R) + (H - T) (disc(r; R + g + t) - disc(r; R + g)), each blurred by sigma,

    B blood, T tissue, H calcium (HU), g the gap and t the calcium's thickness. A ray counts from the axis to the place
    beyond its brightest where it has fallen half-way to the tissue. R, g and t are tried on a grid; the best H of each
    is exact.
    """
    grid = np.arange(NARROWEST_MM, WIDEST_MM, STEP_MM), GAPS_MM, THICK_MM
    radius, gap, thick = (x.ravel()[:, None] for x in np.meshgrid(*grid, indexing="ij"))
    lumen = tissue + (blood - tissue) * disc(r_mm, radius, sigma_mm)
    stone = disc(r_mm, radius + gap + thick, sigma_mm) - disc(r_mm, radius + gap, sigma_mm)
    parts = [hu[k : k + TOGETHER] for k in range(0, len(hu), TOGETHER)]
    return np.concatenate([radius[_best(part, lumen, stone, tissue), 0] for part in parts] or [np.empty(0)])


def _best(hu, lumen, stone, tissue):
    """Indices (n,) of the candidates that fit rays hu (n, k) best; lumen, stone (c, k): of the candidates."""
    behind = np.arange(hu.shape[1]) > hu.argmax(axis=1)[:, None]
    fallen = behind & (hu < 0.5 * (hu.max(axis=1) + tissue)[:, None])
    counts = (np.cumsum(fallen, axis=1) < 2).astype(float)
    # Sums of squares for all rays and candidates at once: |I - lumen - h stone|^2 = a - 2 h b + h^2 c.
    seen = counts * hu
    a = (seen * hu).sum(axis=1)[:, None] - 2 * seen @ lumen.T + counts @ (lumen**2).T
    b = seen @ stone.T - counts @ (lumen * stone).T
    c = counts @ (stone**2).T
    h = np.clip(b / np.maximum(c, 1e-9), 0, DENSEST_HU - tissue)
    return (a - 2 * h * b + h * h * c).argmin(axis=1)
