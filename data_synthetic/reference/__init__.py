"""Finite-element reference of the deployed lumen: plane-strain slices in FEniCSx, a beam that straightens the axis."""
