"""The claims of the evidence section: the tests that they name exist, and the outcomes of these are counted."""

import re

import pytest

from common.errors import InputError
from reports.page import evidence
from reports.page.benchmarks import COSTS, TITLES, read_benchmarks
from reports.page.build import environment
from reports.page.folder import ReportFolder

CASE = '<testcase classname="tests.verification.{}" name="{}" time="0.1">{}</testcase>'
PYTHON, COMPILED = "tests/verification/flow/test_cylinder.py", "tests/verification/vci/test_bending.cpp"


@pytest.fixture
def claims():
    return {claim["id"]: claim for claim in evidence.read_claims()}


@pytest.fixture
def context(tmp_path):
    """context(cases) -> what the section shows after a run with these test cases, as (group, name, XML inside)."""

    def make(*cases):
        written = "".join(CASE.format(*case) for case in cases)
        (tmp_path / "junit.xml").write_text(f'<testsuite timestamp="2026-03-01T09:00:00">{written}</testsuite>')
        return evidence.evidence_context([tmp_path / "junit.xml"], read_benchmarks(None, None))

    return make


def section(context, **more):
    """The section's HTML of a context."""
    return environment().get_template("evidence.html.j2").render(evidence=context, **more)


def test_every_test_benchmark_and_page_of_a_claim_exists(claims, repo_root):
    for claim in claims.values():
        missing = [entry for entry in claim["tests"] if not evidence.named_tests(entry)]
        missing += [name for name in claim["benchmarks"] if name not in TITLES]
        missing += [name for name in claim["records"] if not (repo_root / name).is_file()]
        assert not missing, f"{claim['id']}: {missing}"
        named = [test for entry in claim["tests"] for test in evidence.named_tests(entry)]
        assert len(named) == len(set(named)), f"{claim['id']} counts a test twice"
        assert bool(claim["kinds"]) == bool(claim["tests"] or claim["benchmarks"]), claim["id"]


def test_every_verification_stands_behind_a_claim(claims, repo_root):
    named = {entry.partition("::")[0] for claim in claims.values() for entry in claim["tests"]}
    files = [file.relative_to(repo_root) for file in (repo_root / "tests" / "verification").rglob("test_*")]
    files = [str(file) for file in files if file.suffix in (".py", ".cpp")]
    assert len(files) > 50 and not sorted(set(files) - named)


def test_an_entry_that_names_nothing_is_found():
    assert not evidence.named_tests("tests/verification/flow/test_gone.py")
    assert not evidence.named_tests(f"{PYTHON}::test_gone")
    assert evidence.count_outcomes(f"{PYTHON}::test_gone", {}) == {"passed": 0, "failed": 0, "not_run": 1}


def test_outcomes_of_functions_parameters_and_compiled_suites(monkeypatch, tmp_path):
    """Cases of one test count each; a test without a result, and one that was skipped, did not run."""
    monkeypatch.setattr(evidence, "REPOSITORY", tmp_path)
    for name, text in (
        (PYTHON, "def test_a(x):\n    pass\n\n\ndef helper():\n    pass\n\n\ndef test_b():\n    pass\n"),
        (COMPILED, "TEST(Beam, Bends) {}\nTEST_P(Beam,\n       Wrinkles) {}\n// TEST(Beam, Old)\n"),
    ):
        (tmp_path / name).parent.mkdir(parents=True)
        (tmp_path / name).write_text(text)
    results = [
        {"group": "tests.verification.flow.test_cylinder", "name": "test_a[0.5]", "outcome": "passed"},
        {"group": "tests.verification.flow.test_cylinder", "name": "test_a[a/b.c]", "outcome": "failed"},
        {"group": "tests.verification.vci.Beam", "name": "tests.verification.vci.Beam.Bends", "outcome": "skipped"},
        {"group": "tests.verification.vci.All/Beam", "name": "tests.verification.vci.All/Beam.Wrinkles/0"}
        | {"outcome": "passed"},
    ]
    outcomes = evidence.outcomes_by_test(results)
    assert evidence.count_outcomes(PYTHON, outcomes) == {"passed": 1, "failed": 1, "not_run": 1}
    assert evidence.count_outcomes(f"{PYTHON}::test_b", outcomes) == {"passed": 0, "failed": 0, "not_run": 1}
    assert evidence.count_outcomes(COMPILED, outcomes) == {"passed": 1, "failed": 0, "not_run": 1}


def test_a_claim_shows_its_counts_its_gap_and_its_tests(context, claims):
    (name,) = (found.rpartition(".")[2] for found in evidence.named_tests(PYTHON))
    found = context(("flow.test_cylinder", name, '<failure message="off"/>'))
    (claim,) = (claim for claim in found["claims"] if claim["id"] == "flow_equations")
    total = sum(len(evidence.named_tests(entry)) for entry in claims["flow_equations"]["tests"])
    assert (claim["passed"], claim["failed"], claim["not_run"]) == (0, 1, total - 1)
    text = section(found)
    assert "Last run of the tests, 1 March 2026: 0 passed,\n  1 failed" in text
    assert f"Tests: 0 passed, <mark>1 failed</mark>, {total - 1} not run." in text
    assert f"<code>{PYTHON}</code> 0 passed, <mark>1 failed</mark>, 0 not run" in text
    assert "Walls are rigid, the flow is steady" in text


def test_the_revision_that_the_tests_ran_on_is_shown(context, tmp_path):
    found = context(("flow.test_cylinder", "test_b", ""))
    assert "It may be older than this study." in section(found)
    text = (tmp_path / "junit.xml").read_text()
    recorded = '<properties><property name="revision" value="f71c4ff2 with changes"/></properties>'
    (tmp_path / "junit.xml").write_text(text.replace("<testcase", recorded + "<testcase", 1))
    text = section(evidence.evidence_context([tmp_path / "junit.xml"], read_benchmarks(None, None)))
    assert "They ran on revision f71c4ff2 with changes; " in text and "It may be older" not in text


def test_a_claim_without_evidence_is_shown_as_such(context, claims):
    bare = [claim for claim in claims.values() if not claim["kinds"]]
    text = section(context())
    assert text.count("<mark>No evidence.</mark>") == len(bare) > 0
    assert f"Of {len(claims)} claims," in text and f"and {len(bare)} has no evidence" in re.sub(r"\s+", " ", text)


def test_a_benchmark_is_linked_where_it_is_shown_and_else_its_command_is_given(context, tmp_path):
    folder = tmp_path / "benchmarks" / "flow_fda_jet"
    folder.mkdir(parents=True)
    (folder / "jet.csv").write_text("z,velocity\n0,0.7\n")
    benchmarks = read_benchmarks(tmp_path / "benchmarks", ReportFolder(tmp_path / "report"))
    text = section(evidence.evidence_context([], benchmarks))
    assert '<a href="benchmarks.html#benchmark-flow_fda_jet">' in text and "snakemake -j2 flow_fda_jet" not in text
    assert "snakemake -j2 flow_tolerance" in text and "#benchmark-flow_tolerance" not in text
    shown = environment().get_template("benchmarks.html.j2").render(benchmarks=benchmarks)
    assert set(re.findall(r'href="benchmarks.html#(benchmark-\w+)"', text)) == set(
        re.findall(r'id="(benchmark-\w+)"', shown)
    )


def test_benchmarks_for_a_judgement_that_were_not_run_are_named_with_their_cost():
    text = environment().get_template("benchmarks.html.j2").render(benchmarks=read_benchmarks(None, None))
    assert set(COSTS) < set(TITLES)
    for name, cost in COSTS.items():
        assert f"<code>snakemake -j2 {name}</code>, {cost}" in text


def test_calcium_is_said_to_be_identified():
    assert "by it the strength of calcium was identified" in TITLES["deployment_against_published"][1]


@pytest.mark.parametrize(
    "old, new",
    [('"high: every later step', '"great: every later step'), ("[code verification]", "[tests]"), ("not_shown", "gap")],
)
def test_a_wrong_claim_is_refused(monkeypatch, tmp_path, old, new):
    text = evidence.CLAIMS_FILE.read_text()
    (tmp_path / "claims.yaml").write_text(text.replace(old, new, 1))
    monkeypatch.setattr(evidence, "CLAIMS_FILE", tmp_path / "claims.yaml")
    assert text.replace(old, new, 1) != text
    with pytest.raises(InputError):
        evidence.read_claims()
