"""Runs a program for the benchmarks, and gets its CPU seconds, its exit code and the reason for a refusal."""

import os
import resource
import subprocess


def run_program(command, budget=None):
    """(exit code, text of standard error, CPU seconds) of a program.

    The program is ended once it has used `budget` CPU seconds. Its exit code is then negative.
    """

    def limit_cpu_time():
        resource.setrlimit(resource.RLIMIT_CPU, (budget, budget + 5))

    process = subprocess.Popen(
        [str(c) for c in command],
        stderr=subprocess.PIPE,
        stdout=subprocess.DEVNULL,
        text=True,
        preexec_fn=limit_cpu_time if budget else None,
    )
    messages = process.stderr.read()
    _, status, usage = os.wait4(process.pid, 0)
    process.returncode = os.waitstatus_to_exitcode(status)
    return process.returncode, messages, usage.ru_utime + usage.ru_stime


def refusal_reason(messages):
    """The last error message in the text of standard error, in one line and without its remedy."""
    lines = [line.strip() for line in messages.strip().splitlines()]
    start = max((k for k, line in enumerate(lines) if line.startswith("where:")), default=len(lines))
    return "; ".join(line for line in lines[max(start - 1, 0) : start + 2] if not line.startswith("remedy"))
