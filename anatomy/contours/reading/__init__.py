"""Reads contour tables as frames of outlines, and checks each outline.

May import: common.*.
"""

# The tables of a pull-back. A case file and the command line name them, the latter with - for _.
TABLES = ("lumen", "outer_wall", "calcium", "lipid", "branches", "landmarks")
REGION_TABLES = ("calcium", "lipid")  # plaque; its regions may run round nearly the whole vessel
