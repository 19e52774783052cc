"""The lumen's edge in front of calcium: blurred blood, a gap of soft wall and blurred calcium, fitted on each ray."""

import numpy as np

from .stented import blurred_disc

STEP_MM, NARROWEST_MM, WIDEST_MM = 0.05, 0.2, 3.2  # lumen radii tried: step, least, greatest
GAPS_MM = (0.0, 0.15, 0.3, 0.45, 0.6, 0.8, 1.0)  # thicknesses tried of the soft wall between blood and calcium
THICK_MM = (0.3, 0.5, 0.75, 1.0, 1.4)  # thicknesses tried of the calcium
DENSEST_HU = 1500.0  # of coronary calcium in CT; a denser, thinner sheet would look the same
RAYS_PER_BATCH = 1000  # rays fitted at a time, to limit the memory


def fit(hu, r_mm, blood, tissue, sigma_mm):
    """Lumen radii (n,) in mm on rays with CT numbers hu (n, k) at distances r_mm (k,) from the axis.

    They are the R of the least-squares fit, over R, g, t and H, of

    I(r) = T + (B - T) disc(r; R) + (H - T) (disc(r; R + g + t) - disc(r; R + g)).

    disc(r; R) is a disc of radius R blurred by sigma. B, T and H are the CT numbers of blood, tissue and calcium, g is
    the gap and t the calcium's thickness. Of a ray the part from the axis to half the fall behind its peak is fitted.
    R, g and t are tried on a grid, each with its best H, which follows from a formula.
    """
    grid = np.arange(NARROWEST_MM, WIDEST_MM, STEP_MM), GAPS_MM, THICK_MM
    radius, gap, thick = (x.ravel()[:, None] for x in np.meshgrid(*grid, indexing="ij"))
    lumen = tissue + (blood - tissue) * blurred_disc(r_mm, radius, sigma_mm)
    calcium = blurred_disc(r_mm, radius + gap + thick, sigma_mm) - blurred_disc(r_mm, radius + gap, sigma_mm)
    parts = [hu[k : k + RAYS_PER_BATCH] for k in range(0, len(hu), RAYS_PER_BATCH)]
    return np.concatenate(
        [radius[_best_candidates(part, lumen, calcium, tissue), 0] for part in parts] or [np.empty(0)]
    )


def _best_candidates(hu, lumen, calcium, tissue):
    """Indices (n,) of the candidates that fit the rays hu (n, k) best.

    lumen, calcium: (c, k) profiles of the c candidates, of blood in tissue and of calcium of unit contrast.
    """
    behind = np.arange(hu.shape[1]) > hu.argmax(axis=1)[:, None]
    fallen = behind & (hu < 0.5 * (hu.max(axis=1) + tissue)[:, None])
    counts = (np.cumsum(fallen, axis=1) < 2).astype(float)
    # Sums of squares for all rays and candidates at once: |I - lumen - h calcium|^2 = a - 2 h b + h^2 c.
    fitted_part = counts * hu
    a = (fitted_part * hu).sum(axis=1)[:, None] - 2 * fitted_part @ lumen.T + counts @ (lumen**2).T
    b = fitted_part @ calcium.T - counts @ (lumen * calcium).T
    c = counts @ (calcium**2).T
    h = np.clip(b / np.maximum(c, 1e-9), 0, DENSEST_HU - tissue)
    return (a - 2 * h * b + h * h * c).argmin(axis=1)
