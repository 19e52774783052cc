"""The report's pages name a Snakemake target under each figure and table. Each of these targets has a rule."""

import pytest

from reports.page.sources import SOURCES


@pytest.mark.slow
def test_the_file_named_under_each_figure_and_table_is_a_product(fresh):
    targets = sorted({source.target.format(case="quick_focal") for source in SOURCES.values() if source.target})
    run = fresh.snakemake("--dry-run", *targets)
    assert run.returncode == 0, run.stdout + run.stderr
    unknown = fresh.snakemake("--dry-run", "results/study/another.csv")
    assert unknown.returncode != 0, "Snakemake knows what no rule makes"
