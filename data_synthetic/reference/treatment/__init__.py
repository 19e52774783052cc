"""The treatment: the scene's devices as the solid feels them, and the procedure's steps on any model.

It imports no other folder of the reference.
"""
