"""Figures of the cases and of the study, as SVG and PNG; the same input gives the same bytes.

A new figure is a function here, called in case.py or study.py; docs/extending.md lists the other places to change.

May import: common.*, reports.inputs, reports.measuring, reports.study.
"""
