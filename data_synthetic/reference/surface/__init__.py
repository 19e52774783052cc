"""The lumen's surface: displacement between slices, straightening by the stent, refinement, output.

This folder imports no other folder of the reference.
"""
