"""Simulated CT angiogram of a known lumen, and the error of the lumen segmented from it.

May import: common.*, data_synthetic.
"""
