"""Vessel lumens as implicit fields, whose zero level is the wall, and triangle meshes of that wall.

May import: common.
"""
