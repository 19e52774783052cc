"""Proposes a plan for a measured lumen, sizes and places the devices of a given plan, and draws both.

May import: common.*, anatomy.
"""
