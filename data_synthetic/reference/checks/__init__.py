"""How good the reference is: against the solid in three dimensions, against CalculiX, and with constants changed.

Checks import all other folders of the reference; nothing imports them but the command line.
"""
