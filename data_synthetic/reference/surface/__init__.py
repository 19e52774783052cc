"""The lumen's surface: displacement between slices, refinement, output.

May import: common.*.
"""
