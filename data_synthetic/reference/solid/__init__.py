"""The solid: constants and laws of its materials, places of the tissues, load steps by Newton's method.

It imports neither the slices nor the tube.
"""
