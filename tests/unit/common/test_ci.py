"""What the GitHub workflow and .ci/run call is there."""

import pathlib
import re

import yaml

ROOT = pathlib.Path(__file__).resolve().parents[3]


def commands():
    """The shell lines of both."""
    jobs = yaml.safe_load((ROOT / ".github" / "workflows" / "ci.yml").read_text())["jobs"].values()
    steps = [step["run"] for job in jobs for step in job["steps"] if "run" in step]
    matrix = [one["command"] for job in jobs if "strategy" in job for one in job["strategy"]["matrix"]["include"]]
    return "\n".join([*steps, *matrix, (ROOT / ".ci" / "run").read_text()])


def test_targets_and_files_exist():
    makefile, text = (ROOT / "Makefile").read_text(), commands()
    targets = set(re.findall(r"(?:^|&& )make ([a-z-]+)", text, re.M))
    assert targets >= {"test", "test-slow", "test-long", "study", "docs", "build", "coverage", "fuzz"}
    assert [target for target in targets if not re.search(rf"^{target}:", makefile, re.M)] == []
    files = re.findall(r"(?:\.ci|tests|config|setup)/[\w./-]+", text)
    assert len(files) >= 4 and [file for file in files if not (ROOT / file).exists()] == []
