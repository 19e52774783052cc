"""Measures each case, compares the states over the cohort, and writes the tables, the figures and the report."""
