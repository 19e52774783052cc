"""The FDA's nozzle in the meridian plane, with the equations and elements of axisymmetric.py.

The mesh consists of two grids that share a row of nodes. The core is as wide as the throat behind the sudden expansion.
The ring lies round the core, behind the expansion only. Cells get smaller towards the expansion and the throat's edge.
"""

import axisymmetric
import fda_nozzle
import numpy as np

ENDS = np.cumsum([0.0, fda_nozzle.INLET_MM, fda_nozzle.CONE_MM, fda_nozzle.THROAT_MM, fda_nozzle.OUTLET_MM])
WIDTHS = (fda_nozzle.RADIUS, fda_nozzle.RADIUS, fda_nozzle.THROAT, fda_nozzle.THROAT)  # radius of the core at ENDS
GRADING = (0.0, 0.0, -3.0, 4.5)  # log of the ratio of the last cell's length to the first's, between ENDS
COUNTS = (10, 24, 44, 80)  # cells between ENDS
CORE, RING = 8, 12  # cells across


def graded(count, strength):
    """Fractions (2 count + 1,) of a length at the nodes of `count` cells; the last is exp(strength) times the first."""
    x = np.linspace(0, 1, 2 * count + 1)
    return np.expm1(strength * x) / np.expm1(strength) if strength else x


class Nozzle(axisymmetric.Tube):
    """The flow through the nozzle; document: as boundary.json; refined: factor on the numbers of cells."""

    def __init__(self, document, refined=1.0):
        self.refined = refined
        super().__init__(lambda s: np.interp(s, ENDS[:4], WIDTHS), float(ENDS[-1]), float(ENDS[3]), document, (1, 1))

    def _mesh(self):
        counts = [round(self.refined * count) for count in COUNTS]
        core, ring = (round(self.refined * count) for count in (CORE, RING))
        s = [ENDS[:1]]
        for k, count in enumerate(counts):
            s.append(ENDS[k] + (ENDS[k + 1] - ENDS[k]) * graded(count, GRADING[k])[1:])
        s, step = np.concatenate(s), 2 * sum(counts[:3])
        inside = np.interp(s, ENDS[:4], WIDTHS)[:, None] * graded(core, -1.5)
        outside = fda_nozzle.THROAT + (fda_nozzle.RADIUS - fda_nozzle.THROAT) * graded(ring, 2.5)[1:]
        number = np.arange(inside.size).reshape(inside.shape)
        behind = inside.size + np.arange((len(s) - step) * len(outside)).reshape(-1, len(outside))
        x = np.concatenate([np.repeat(s, inside.shape[1]), np.repeat(s[step:], len(outside))])
        r = np.concatenate([inside.ravel(), np.tile(outside, len(s) - step)])
        ring_number = np.column_stack([number[step:, -1], behind])
        cells = np.concatenate([axisymmetric.cells_of(number), axisymmetric.cells_of(ring_number)])
        return axisymmetric.quadrilaterals(1e-3 * np.stack([x, r], axis=1), cells)

    def at(self, s_mm, r_mm):
        """(velocity along the axis (n,) in m/s, pressure (n,) in Pa) at s_mm (n,), r_mm from the axis."""
        points = np.zeros((len(s_mm), 3))
        points[:, 0], points[:, 1] = 1e-3 * np.asarray(s_mm), 1e-3 * r_mm
        cells = axisymmetric.containing_cells(self.domain, points)
        return self.state.sub(0).eval(points, cells)[:, 0], self.state.sub(1).eval(points, cells)[:, 0]

    def solve(self, flow):
        """Solves at the inflow `flow` (m3/s), raised step by step."""
        for fraction in axisymmetric.FRACTIONS:
            self._solve(fraction * flow)
