"""Measures each case, compares its states over the cohort, and writes tables, figures and the report."""

import common  # noqa: F401  chooses functions that round alike on every processor, before numpy is loaded
