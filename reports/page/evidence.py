"""Test results for the evidence table, from JUnit XML as pytest, GoogleTest and CTest write it."""

import xml.etree.ElementTree as ElementTree

from common.errors import InputError
from reports.inputs.reading import require_file


def read_test_results(paths):
    """[{group, name, outcome, seconds, reason}] of all test cases; InputError for a file that is no JUnit XML."""
    results = []
    for path in paths:
        try:
            root = ElementTree.parse(require_file(path, "make test")).getroot()
        except ElementTree.ParseError as error:
            raise InputError("test results cannot be read", path, str(error), "repeat the tests") from error
        if root.tag not in ("testsuites", "testsuite"):
            raise InputError("not a file of test results", path, root.tag, "give JUnit XML")
        for case in root.iter("testcase"):
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


def test_group(case):
    """The test's group: the class of a <testcase>. CTest writes the full name as class, so its last word is cut off."""
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
