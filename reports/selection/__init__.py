"""Table of the patients, and which of them meet the study's criterion of inclusion.

May import: common.*, reports.inputs, reports.measuring, reports.study, reports.figures.
"""
