"""The lumen's edge in front of calcium: blurred blood, a gap of soft wall and blurred calcium, fitted on each ray."""

import numpy as np

from .stented import blurred_disc

STEP_MM = 0.05  # step of the radii that are tried; all lengths below are whole numbers of it
NARROWEST_MM, WIDEST_MM = 0.2, 3.2  # lumen radii that are tried
GAPS_MM = (0.0, 0.15, 0.3, 0.45, 0.6, 0.8, 1.0)  # thicknesses tried for the soft wall between blood and calcium
THICK_MM = (0.3, 0.5, 0.75, 1.0, 1.4)  # thicknesses tried for the calcium
DENSEST_HU = 1500.0  # densest coronary calcium in CT; without a limit a denser, thinner sheet would look the same
RAYS_PER_BATCH = 1000  # rays fitted at a time, to limit the memory


def fit(hu, r_mm, blood, tissue, sigma_mm):
    """Lumen radii (n,) in mm on rays with CT numbers hu (n, k) at distances r_mm (k,) from the axis.

    This model is fitted to each ray by least squares over R, g, t and H, and its R is returned.

    I(r) = T + (B - T) disc(r; R) + (H - T) (disc(r; R + g + t) - disc(r; R + g)).

    disc(r; R) is a disc of radius R blurred by sigma. B, T and H are the CT numbers of blood, tissue and calcium, g is
    the gap and t the calcium's thickness. The ray is fitted from the axis to the place behind its peak where it has
    fallen half-way to the tissue. R, g and t are tried on a grid. The best H for each follows from a formula.
    """
    lengths = np.arange(NARROWEST_MM, WIDEST_MM, STEP_MM), GAPS_MM, THICK_MM
    steps = (np.rint(np.asarray(length) / STEP_MM).astype(int) for length in lengths)
    radius, gap, thick = (x.ravel() for x in np.meshgrid(*steps, indexing="ij"))
    outer = radius + gap + thick
    # Thousands of candidates share a hundred radii, and a blurred disc is the costly part.
    discs = blurred_disc(r_mm, STEP_MM * np.arange(outer.max() + 1)[:, None], sigma_mm)
    lumen, calcium = tissue + (blood - tissue) * discs[radius], discs[outer] - discs[radius + gap]
    parts = [hu[k : k + RAYS_PER_BATCH] for k in range(0, len(hu), RAYS_PER_BATCH)]
    return np.concatenate(
        [STEP_MM * radius[_best_candidates(part, lumen, calcium, tissue)] for part in parts] or [np.empty(0)]
    )


def _best_candidates(hu, lumen, calcium, tissue):
    """Indices (n,) of the candidates that fit the rays hu (n, k) best.

    lumen (c, k): profiles of blood in tissue for c candidates. calcium (c, k): profiles of calcium with a contrast of
    1 HU.
    """
    behind = np.arange(hu.shape[1]) > hu.argmax(axis=1)[:, None]
    fallen = behind & (hu < 0.5 * (hu.max(axis=1) + tissue)[:, None])
    counts = (np.cumsum(fallen, axis=1) < 2).astype(float)
    # The sum of squares |I - lumen - h calcium|^2 = a - 2 h b + h^2 c, for all rays and candidates at once.
    fitted_part = counts * hu
    a = (fitted_part * hu).sum(axis=1)[:, None] - 2 * fitted_part @ lumen.T + counts @ (lumen**2).T
    b = fitted_part @ calcium.T - counts @ (lumen * calcium).T
    c = counts @ (calcium**2).T
    h = np.clip(b / np.maximum(c, 1e-9), 0, DENSEST_HU - tissue)
    return (a - 2 * h * b + h * h * c).argmin(axis=1)
