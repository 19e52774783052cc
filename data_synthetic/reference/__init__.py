"""Finite-element reference of the deployed lumen: slices in plane strain, and a beam that straightens the axis."""
