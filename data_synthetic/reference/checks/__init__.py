"""Checks of the reference: against a solid in three dimensions, against CalculiX, and with changed constants.

Only the command line imports this folder.

May import: common.*, data_synthetic.reference.*.
"""
