"""Which cases of a run failed, at which step and why. The report page on the other cases lists them."""

import pathlib

from common.documents import json_reader, schema
from common.errors import InputError, error_message
from common.files import write_json
from workflow.half_maximum import ARM_NAME as ARM

INTERRUPT_EXIT_CODES = (130, 143)  # exit codes of a step ended by Ctrl-C or SIGTERM, which is no failure


def failed_steps(results=pathlib.Path("results"), since=0.0):
    """[{case, step, exit_code, message, log}] of the steps of cases that failed at or after a time.

    since: that time, in seconds since the epoch. If a step's command fails, workflow/run.sh marks the step's log below
    results/cases/<case>/logs.
    """
    found = []
    for mark in sorted(pathlib.Path(results).glob("cases/*/logs/**/*.log.failed")):
        code = _exit_code(mark)
        if mark.stat().st_mtime < since or code in INTERRUPT_EXIT_CODES:
            continue
        log = mark.with_suffix("")
        case, step = log.relative_to(results).parts[1], log.with_suffix("").relative_to(results).parts[3:]
        text = log.read_text(errors="replace") if log.exists() else ""
        found.append({"case": case, "step": "/".join(step), "exit_code": code, "message": error_message(text)})
        found[-1]["log"] = str(log)
    return found


def write_failed(out, results=pathlib.Path("results"), since=0.0):
    """Writes {failed: result of failed_steps} to `out` if a step failed. Returns the failed steps."""
    found = failed_steps(results, since)
    if found:
        pathlib.Path(out).parent.mkdir(parents=True, exist_ok=True)
        write_json(out, {"failed": found})
    return found


def without_failed(cases, path):
    """The cases that have no failed step in failed.json at `path`; all cases if no path is given.

    If a step of the half-maximum arm failed (workflow.half_maximum), the case loses only this arm and stays. Raises
    InputError if the file cannot be read, or if no case is left.
    """
    if not path:
        return cases
    failed = {case for case, step in _read_steps(path) if not _is_arm_step(step)}
    left = [case for case in cases if case not in failed]
    if not left:
        raise InputError("every case failed", path, " ".join(cases), "read their logs: there is no page to make")
    return left


def cases_of_failed_arms(path):
    """The cases in which a step of the half-maximum arm failed; none if no path is given.

    Raises InputError if the file cannot be read.
    """
    return {case for case, step in _read_steps(path) if _is_arm_step(step)} if path else set()


def _read_steps(path):
    """[(case, step)] of a failed.json. Raises InputError for another file."""
    remedy = "--config failed= takes the file of `workflow failed`"
    document = json_reader.read(path, "failed.json", remedy)
    schema.validate(document, schema.read("failed"), "a list of failed steps", remedy)
    return [(step["case"], step["step"]) for step in document.data["failed"]]


def _is_arm_step(step):
    """Whether a failed step belongs to the half-maximum arm."""
    return step.partition("/")[0] == ARM


def _exit_code(mark):
    """The exit code in a mark; None if the mark was cut short."""
    text = mark.read_text().strip()
    return int(text) if text.isdigit() else None
