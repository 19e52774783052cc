"""Finds where the lumen ends on a ray from its axis: beside wall, beside calcium and in a stent.

May import: no other folder.
"""
