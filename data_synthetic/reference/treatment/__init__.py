"""The treatment: the scene's devices as loads on the solid, and the procedure's steps on any model.

It imports no other folder of the reference.
"""
