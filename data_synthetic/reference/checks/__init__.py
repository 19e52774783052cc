"""What the reference is worth: against the solid in three dimensions, against CalculiX, and with its constants changed.

Checks import all other folders of the reference; nothing imports them but the command line.
"""
