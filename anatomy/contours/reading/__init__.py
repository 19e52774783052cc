"""Reads contour tables as frames of outlines, and checks each outline."""
