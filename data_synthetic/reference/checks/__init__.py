"""Checks of the reference: against a solid in three dimensions, against CalculiX, and with changed constants.

Checks import all other folders of the reference; only the command line imports them.
"""
