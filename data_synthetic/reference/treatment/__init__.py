"""The treatment: the scene's devices as loads on the solid, and the procedure's steps on any model.

May import: common.*.
"""
