"""The lumen's surface: displacement between slices, straightening by the stent, refinement, output.

May import: common.*.
"""
