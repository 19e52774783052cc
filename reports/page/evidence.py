"""The evidence section: the study's claims, and the results of the tests behind them.

The results are JUnit XML, as pytest, GoogleTest and CTest write it.
"""

import datetime
import pathlib
import re
import xml.etree.ElementTree as ElementTree

from common.documents import config
from common.errors import InputError
from reports.inputs.reading import require_file
from reports.page.benchmarks import TITLES

CLAIMS_FILE = pathlib.Path(__file__).with_name("claims.yaml")
REPOSITORY = pathlib.Path(__file__).resolve().parents[2]
PYTHON_TEST = re.compile(r"^def (test_\w+)", re.MULTILINE)
COMPILED_TEST = re.compile(r"^TEST(?:_[FP])?\(\s*(\w+),\s*(\w+)\)", re.MULTILINE)  # GoogleTest: suite, name
OUTCOMES = ("passed", "failed", "not_run")
VALIDATION = ("validation against benches", "validation against patients")


def evidence_context(junit, benchmarks):
    """{claims, rows, days, revisions}: results of claim_row, of evidence_rows, days_of_tests and revisions_of_tests.

    junit: files of test results. benchmarks: result of read_benchmarks. Raises InputError for a file that cannot be
    read.
    """
    results = read_test_results(junit)
    outcomes = outcomes_by_test(results)
    shown = {benchmark["name"] for benchmark in benchmarks if benchmark["tables"]}
    return {
        "claims": [claim_row(claim, outcomes, shown) for claim in read_claims()],
        "rows": evidence_rows(results),
        "days": days_of_tests(junit),
        "revisions": revisions_of_tests(junit),
    }


def read_claims():
    """The entries of claims.yaml, with the keys of config/schemas/claims.schema.yaml. InputError if one is wrong."""
    return config.load(CLAIMS_FILE, "claims")["claims"]


def claim_row(claim, outcomes, shown):
    """A claim with the number of its tests by outcome (OUTCOMES): in all, and for each of its entries in `tests`.

    `tests` becomes [{entry, passed, failed, not_run}], `benchmarks` becomes [{name, title, shown}]. `validated` says
    whether the claim was compared with benches or patients. outcomes: result of outcomes_by_test. shown: names of the
    benchmarks whose tables the report has.
    """
    tests = [{"entry": entry, **count_outcomes(entry, outcomes)} for entry in claim["tests"]]
    return {
        **claim,
        **{key: sum(test[key] for test in tests) for key in OUTCOMES},
        "tests": tests,
        "benchmarks": [
            {"name": name, "title": TITLES[name][0], "shown": name in shown} for name in claim["benchmarks"]
        ],
        "validated": any(kind in VALIDATION for kind in claim["kinds"]),
    }


def count_outcomes(entry, outcomes):
    """{passed, failed, not_run}: number of test cases of a claim's entry, which is a file or file::function.

    A test without any result counts once as not run, since a run may leave out slow tests. An entry that names no test
    counts once as not run, too.
    """
    cases = [outcome for test in named_tests(entry) or [entry] for outcome in outcomes.get(test, ["skipped"])]
    counts = {outcome: cases.count(outcome) for outcome in ("passed", "failed", "skipped")}
    return {"passed": counts["passed"], "failed": counts["failed"], "not_run": counts["skipped"]}


def named_tests(entry):
    """Identifiers (as in outcomes_by_test) of the tests that an entry of claims.yaml names; empty if none exists.

    They are read from the tests' sources, since the results lack tests that were left out.
    """
    name, _, function = entry.partition("::")
    file = pathlib.PurePath(name)
    text = (REPOSITORY / file).read_text() if (REPOSITORY / file).is_file() else ""
    if file.suffix == ".cpp":
        return [".".join((*file.parent.parts, *found)) for found in COMPILED_TEST.findall(text)]
    functions = [found for found in PYTHON_TEST.findall(text) if function in ("", found)]
    return [".".join((*file.with_suffix("").parts, found)) for found in functions]


def outcomes_by_test(results):
    """{identifier: outcomes of the test's cases}. identifier: group.name, without the parameters of a test."""
    found = {}
    for result in results:
        name = result["name"].split("[")[0].rpartition(".")[2].split("/")[0]
        identifier = re.sub(r"[^./]+/", "", result["group"]) + "." + name
        found.setdefault(identifier, []).append(result["outcome"])
    return found


def read_test_results(paths):
    """[{group, name, outcome, seconds, reason}] of all test cases; InputError for a file that is no JUnit XML."""
    results = []
    for path in paths:
        for case in read_junit(path).iter("testcase"):
            outcome, reason = test_outcome(case)
            results.append(
                {
                    "group": test_group(case),
                    "name": case.get("name", ""),
                    "outcome": outcome,
                    "reason": reason,
                    "seconds": float(case.get("time", 0.0)),
                }
            )
    return results


def read_junit(path):
    """The root element of a file of test results. Raises InputError for a file that is no JUnit XML."""
    try:
        root = ElementTree.parse(require_file(path, "make test")).getroot()
    except ElementTree.ParseError as error:
        raise InputError("test results cannot be read", path, str(error), "repeat the tests") from error
    if root.tag not in ("testsuites", "testsuite"):
        raise InputError("not a file of test results", path, root.tag, "give JUnit XML")
    return root


def days_of_tests(paths):
    """The days on which the test runs in JUnit files began, such as ["27 November 2026"]. A file may name no day."""
    stamps = {suite.get("timestamp", "")[:10] for path in paths for suite in read_junit(path).iter("testsuite")}
    days = sorted(datetime.date.fromisoformat(stamp) for stamp in stamps if stamp)
    return [f"{day.day} {day:%B %Y}" for day in days]


def revisions_of_tests(paths):
    """The revisions that the tests in JUnit files ran on, as tests/conftest.py records them. A file may name none."""
    properties = [found for path in paths for found in read_junit(path).iter("property")]
    return sorted({found.get("value", "") for found in properties if found.get("name") == "revision"})


def test_group(case):
    """The test's group: the class of a <testcase>. CTest writes the full name there, so the last word is cut off."""
    group, name = case.get("classname", ""), case.get("name", "")
    return name.rpartition(".")[0] if group == name else group


def test_outcome(case):
    """(outcome, reason) of a <testcase>. A failure or error counts first; a test that did not run is skipped."""
    for tag, outcome in (("failure", "failed"), ("error", "failed"), ("skipped", "skipped")):
        found = case.find(tag)
        if found is not None:
            return outcome, (found.get("message") or found.text or "").strip()
    if case.get("status") in ("notrun", "disabled"):
        return "skipped", "not run"
    return "passed", ""


def split_group(group):
    """(kind, part, the rest) of a test group such as "tests.verification.flow.test_poiseuille"."""
    words = [word for word in group.replace("/", ".").split(".") if word not in ("tests", "")]
    kind = words.pop(0) if words and words[0] in ("unit", "verification", "workflow") else "unit"
    part = words.pop(0) if len(words) > 1 else ""
    return kind, part, ".".join(words)


def evidence_rows(results):
    """Rows {kind, part, tests, passed, failed, skipped, seconds, reasons} by group, verification first."""
    groups = {}
    for result in results:
        row = groups.setdefault(
            result["group"], {"passed": 0, "failed": 0, "skipped": 0, "seconds": 0.0, "reasons": []}
        )
        row[result["outcome"]] += 1
        row["seconds"] += result["seconds"]
        if result["outcome"] != "passed" and result["reason"] not in row["reasons"]:
            row["reasons"].append(result["reason"])
    rows = []
    for group, row in groups.items():
        kind, part, tests = split_group(group)
        rows.append({"tests": tests, "kind": kind, "part": part, **row})
    return sorted(rows, key=lambda row: (row["kind"] != "verification", row["kind"], row["part"], row["tests"]))
