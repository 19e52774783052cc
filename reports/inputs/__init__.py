"""Reads a case: its files, numbers, tables, lines and surfaces. Wrong input is refused with a message.

May import: common.*.
"""
