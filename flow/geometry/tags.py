"""Physical groups of a gmsh file: which facets are wall, inlet and outlets."""

PHYSICAL_WALL, PHYSICAL_INLET, PHYSICAL_OUTLET_BASE, PHYSICAL_VOLUME = 1, 2, 10, 1


def physical_tag(region_id):
    """Number of the physical group for a region_id of the surface: wall 1, inlet 2, outlets 10 + region_id."""
    return {0: PHYSICAL_WALL, 1: PHYSICAL_INLET}.get(region_id, PHYSICAL_OUTLET_BASE + region_id)
