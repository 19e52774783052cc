"""Figures of the cases and of the study, as SVG and PNG; the same input gives the same bytes."""
