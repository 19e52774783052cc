"""Other plans and other inputs of a case: reads the tables of `whatif`, draws them, and prepares them for the page.

May import: common.*, reports.inputs, reports.measuring, reports.study, reports.figures.
"""
