"""Reading a case: its files, numbers, tables, lines and surfaces; what is wrong is refused with a message.

It imports no other folder of the reports.
"""
