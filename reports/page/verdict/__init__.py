"""The verdict at the head of the page: what the study found, in a few sentences made from its own tables.

May import: reports.page, common.*, reports.inputs, reports.measuring, reports.study, reports.figures, reports.whatif,
reports.selection.
"""
