"""How far a stent straightens its vessel: two beams, the stent and the vessel, that press on each other.

May import: common.*.
"""
