"""Spans, the stretches of a tree's branches that are swept: finds, sweeps and shortens them."""

import dataclasses
import sys

import numpy as np

from flow.geometry.jet import jet_radius
from flow.meshing.sweep import lattice, spans, stations

SAMPLING_RADII = 0.2  # distance in radii of the sample sections that show where a branch can be swept
SHEAR_SPREAD = 0.03  # mm by which the radius of a jet grows per mm along the branch
MOST_REFINEMENTS = 3  # most rounds in which a station is added between two with turned-over tetrahedra between them


@dataclasses.dataclass
class Span:
    """A swept stretch of a branch, from start_mm to end_mm along its Axis.

    caps: region ids of the inlet or outlet caps at its two ends, or None; lattice: lattice.Lattice, None before
    `sweep_span`; sections: lattice.Sections; stations: number of stations.
    """

    axis: object
    start_mm: float
    end_mm: float
    caps: tuple
    lattice: object = None
    sections: object = None
    stations: int = 0

    def s_at_end(self, which):
        """Arc length in mm of the span's first (0) or last (1) end."""
        return (self.start_mm, self.end_mm)[which]


def find_spans(surface, tree, slicer, disc):
    """[Span] of all branches of the tree, not swept yet.

    Every sample section of a span is clear of other branches, and star-shaped unless it is very near to a cap. slicer:
    section.Slicer of `surface`.
    """
    angles = np.pi * np.arange(2 * len(disc.rim)) / len(disc.rim)
    found = []
    for axis in spans.branch_axes(surface, tree).values():
        s = stations.spread_by_gap(0.0, axis.length_mm, lambda at: SAMPLING_RADII * axis.radius(at), 2)
        allowed = spans.clear_of_others(axis, tree, s)
        inner = s[allowed]
        if len(inner) < 2:
            continue
        _, ok, _, _ = lattice.Sections(slicer, axis, inner).radii(angles)
        # This near to a cap, the cap's rim may cut a sample section. That does not matter: the sweep's end section is
        # the rim.
        near_cap = np.zeros(len(s), bool)
        near_cap |= (axis.cap_ids[0] is not None) & (s <= 0.5 * axis.radius(0.0))
        near_cap |= (axis.cap_ids[1] is not None) & (axis.length_mm - s <= 0.5 * axis.radius(axis.length_mm))
        allowed[np.flatnonzero(allowed)[~ok]] = False
        allowed |= near_cap & spans.clear_of_others(axis, tree, s)
        for start, end, first, last in spans.sweepable_stretches(axis, allowed, s):
            found.append(Span(axis, start, end, (first, last)))
    return found


def sweep_span(span, slicer, disc, settings, coarsening):
    """Places the stations of a span and builds its lattice, with further stations where tetrahedra are inverted.

    coarsening: factor of the distance of the stations. The lattice stays None if a section is not star-shaped, or if
    tetrahedra stay inverted.
    """
    branch = span.axis.branch
    station_s = stations.place_stations(branch, settings, span.start_mm, span.end_mm, coarsening)
    for _ in range(1 + MOST_REFINEMENTS):
        levels = np.sort(np.concatenate([station_s, 0.5 * (station_s[1:] + station_s[:-1])]))
        span.sections = lattice.Sections(slicer, span.axis, levels, span.caps)
        if any(item is None for item in span.sections.sections):
            return
        jet_share = np.interp(levels, branch.s_mm, jet_radius(branch, SHEAR_SPREAD) / branch.radius_mm)
        built = lattice.build(span.sections, disc, jet_share)
        inverted = [] if built is None else lattice.inverted_gaps(built, disc)
        if not len(inverted):
            span.lattice, span.stations = built, len(station_s)
            return
        station_s = np.sort(np.concatenate([station_s, 0.5 * (station_s[inverted] + station_s[inverted + 1])]))
    stretch = f"{branch.name} {span.start_mm:.1f}-{span.end_mm:.1f} mm"
    print(f"{stretch}: swept cells stay inverted, meshed as a junction", file=sys.stderr, flush=True)


def shorten_spans(all_spans, ends, radii):
    """The spans `all_spans`, with some ends moved inwards by `radii` radii; spans that get too short are dropped.

    ends: (span number, 0 for its first or 1 for its last end).
    """
    kept = []
    for number, span in enumerate(all_spans):
        for which in (0, 1):
            if (number, which) in ends:
                shift = radii * float(span.axis.radius(span.s_at_end(which)))
                span = dataclasses.replace(span, lattice=None)
                if which == 0:
                    span.start_mm += shift
                else:
                    span.end_mm -= shift
        radius = max(span.axis.radius(span.start_mm), span.axis.radius(span.end_mm))
        if span.end_mm - span.start_mm >= spans.SHORTEST_RADII * radius:
            kept.append(span)
    return kept
