"""Measures each case, compares its states over the cohort, and writes tables, figures and the report."""
