"""Contour tables as frames of outlines, and the checks of each outline."""
