"""The solid: constants of its materials, where the tissue lies, its laws, load steps by Newton's method.

It knows no slice and no tube.
"""
