"""Measures each case, compares its states over the cohort, and writes tables, figures and the report.

May import: common.*, reports.*.
"""

import common  # noqa: F401  before numpy is loaded: makes it round alike on every processor
