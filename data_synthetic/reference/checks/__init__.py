"""Checks of the reference: against a solid in three dimensions, against CalculiX, and with changed constants.

This folder imports all other folders of the reference; only the command line imports this one.
"""
