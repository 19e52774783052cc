"""Vessel wall and plaque as a solid: material constants and laws, places of the tissues, loading in steps.

This folder imports neither the slices nor the tube.
"""
