"""Vessel wall and plaque as a solid: material constants and laws, places of the tissues, loading in steps.

May import: common.*.
"""
