"""Vessel wall and plaque as a solid: material constants and laws, places of the tissues, load steps by Newton's method.

This folder imports neither the slices nor the tube.
"""
