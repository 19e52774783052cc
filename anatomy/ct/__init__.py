"""Makes a lumen surface with calcium from a CT angiogram.

May import: common.*, anatomy.ct.rays.
"""
