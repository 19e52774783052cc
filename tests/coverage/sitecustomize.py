"""Every Python that tests/coverage/run.sh starts finds this module first, and counts the lines it runs."""

import coverage

coverage.process_startup()
