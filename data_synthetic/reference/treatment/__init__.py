"""The treatment: the scene's devices as loads on the solid, and the procedure's steps on any model.

This folder imports no other folder of the reference.
"""
