"""docs/results.md names every product of the workflow, and no other."""

import re

import pytest

pytestmark = pytest.mark.slow


def documented(repo_root):
    """Paths in the first code block of docs/results.md, braces expanded."""
    block = re.search(r"```\n(results/.*?)```", (repo_root / "docs" / "results.md").read_text(), re.S).group(1)
    found = set()
    for line in block.splitlines():
        path = line.split("  ")[0].strip()
        found |= set(expand(path)) if path else set()
    return found


def expand(path):
    """a/{b,c}.d -> a/b.d, a/c.d."""
    choice = re.search(r"\{([^{}]*)\}", path)
    if not choice:
        return [path]
    return [
        one
        for item in choice.group(1).split(",")
        for one in expand(path[: choice.start()] + item + path[choice.end() :])
    ]


def test_results_page_matches_the_rules(fresh, repo_root):
    """Three cohorts together have every product. The synthetic cases of `quick` have a reference and CT. The cases of
    `real` have contours and a lumen after the procedure. `contrast` has radius correction by the stents alone.
    """
    made = set()
    for job in [job for cohort in ("quick", "real", "contrast") for job in fresh.planned_jobs(cohort=cohort)]:
        for name in job["output"]:
            state, section = job["wildcards"].get("state"), job["wildcards"].get("section")
            name = name.replace(job["wildcards"].get("case", "<case>"), "<case>")
            name = name.replace(f"/{state}/", "/<state>/") if state else name
            made.add(name.replace(f"/{section}.json", "/<section>.json") if section else name)
    assert made == documented(repo_root)
