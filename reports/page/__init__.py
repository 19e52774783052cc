"""The study's report: one HTML file that holds all its content and fetches nothing.

May import: common.*, reports.inputs, reports.measuring, reports.study, reports.figures, reports.whatif,
reports.selection.
"""
