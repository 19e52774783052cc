"""Machine-readable record of a finished study: its numbers in one JSON file, and its files as a research object.

May import: common.*, reports.inputs, reports.measuring, reports.study, reports.figures, reports.whatif, reports.page.
"""
