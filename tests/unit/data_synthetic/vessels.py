"""Vessels that the tests share, with the schema's defaults filled in."""

from common.documents import schema


def vessel(**changes):
    """A small vessel: one side branch, one focal lesion; `changes` replace top-level keys."""
    data = {
        "seed": 7,
        "main": {"length_mm": 30, "ostial_diameter_mm": 3.4},
        "side_branches": [{"s_mm": 21, "diameter_mm": 1.6, "length_mm": 7.5, "azimuth_deg": 40}],
        "lesions": [{"centre_s_mm": 11, "length_mm": 8, "diameter_stenosis_percent": 60, "eccentricity": 0.5}],
    }
    data.update(changes)
    return schema.with_defaults(data, schema.read("vessel"))
