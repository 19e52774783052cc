"""Snakemake log handler (config/profiles/local): says about every minute how long the run will still take.

A step that has not finished is expected to take the mean time of its rule's finished steps. If there are none, it is
expected to take the rule's TYPICAL_SECONDS, scaled by this run's speed so far. The sum is divided by the mean number of
steps that ran at once. The order of the steps is ignored, so the last minutes are underestimated.
"""

import collections
import re
import sys
import time

# Seconds of a step by rule, guessed for a patient of the cohort `nine` on an idle core. A guess is used until the first
# step of its rule has finished.
TYPICAL_SECONDS = {
    "flow_solve": 60,
    "flow_mesh": 15,
    "reference": 60,
    "ct_phantom": 15,
    "ct_segment": 20,
    "other_plans": 70,
}
TYPICAL_SECONDS |= {
    "deploy": 8,
    "ct_deploy": 8,
    "generate": 8,
    "case_figures": 10,
    "ct_figure": 5,
    "procedure_figure": 8,
}
TYPICAL_SECONDS |= {"half_maximum_segment": 20, "half_maximum_deploy": 8}
TYPICAL_SECONDS |= {"flow_sensitivity": 17, "settings": 0, "all": 0}
DEFAULT_SECONDS = 3  # seconds of any other rule
ESTIMATE_INTERVAL_S, FEWEST_STEPS = 60.0, 10  # seconds between two estimates; finished steps before the first


class TimeLeft:
    """Counts a run's finished and open steps. clock: function that returns seconds."""

    def __init__(self, clock=time.monotonic):
        self.clock, self.start_time, self.last_estimate = clock, clock(), clock()
        self.planned, self.open_steps = collections.Counter(), {}
        self.finished_counts, self.finished_seconds = collections.Counter(), collections.Counter()

    def read_plan(self, table):
        """Reads the table of jobs that Snakemake prints. A line has rule, number of jobs, least and most threads."""
        for line in table.splitlines():
            found = re.match(r"(\w+)\s+(\d+)\s+\d+\s+\d+$", line.strip())
            if found and found[1] != "total":
                self.planned[found[1]] = int(found[2])

    def start_step(self, job, rule):
        """Notes that a step has begun."""
        self.open_steps[job] = rule, self.clock()

    def finish_step(self, job):
        """Notes that a step has ended."""
        if job in self.open_steps:
            rule, begin = self.open_steps.pop(job)
            self.finished_counts[rule] += 1
            self.finished_seconds[rule] += self.clock() - begin

    def remaining_s(self):
        """Seconds until the run ends; None before FEWEST_STEPS have finished."""
        finished, total_seconds = sum(self.finished_counts.values()), sum(self.finished_seconds.values())
        if finished < FEWEST_STEPS or not total_seconds:
            return None
        known = [rule for rule in self.finished_counts if TYPICAL_SECONDS.get(rule, DEFAULT_SECONDS)]
        typical_total = sum(self.finished_counts[rule] * TYPICAL_SECONDS.get(rule, DEFAULT_SECONDS) for rule in known)
        slowdown = sum(self.finished_seconds[rule] for rule in known) / typical_total if typical_total else 1.0
        concurrency = max(1.0, total_seconds / (self.clock() - self.start_time))
        return (
            sum(self._expected_seconds(rule, slowdown) * self._unfinished_steps(rule) for rule in self.planned)
            / concurrency
        )

    def _unfinished_steps(self, rule):
        return max(0, self.planned[rule] - self.finished_counts[rule])

    def _expected_seconds(self, rule, slowdown):
        if self.finished_counts[rule]:
            return self.finished_seconds[rule] / self.finished_counts[rule]
        return slowdown * TYPICAL_SECONDS.get(rule, DEFAULT_SECONDS)

    def estimate_message(self):
        """The sentence to print if an estimate is due, else None."""
        left = self.remaining_s()
        if left is None or self.clock() - self.last_estimate < ESTIMATE_INTERVAL_S:
            return None
        self.last_estimate = self.clock()
        return f"about {duration(left)} left, by the {sum(self.finished_counts.values())} steps done so far"


def duration(seconds):
    """A duration in words: 40 s, 12 min, 2 h 05 min."""
    minutes = round(seconds / 60)
    if minutes < 1:
        return f"{seconds:.0f} s"
    return f"{minutes} min" if minutes < 60 else f"{minutes // 60} h {minutes % 60:02d} min"


CURRENT_RUN = TimeLeft()


def log_handler(message):
    """Called by Snakemake with each of its log messages (a dict)."""
    level = message["level"]
    if level == "run_info":
        CURRENT_RUN.read_plan(message["msg"])
    elif level == "job_info":
        CURRENT_RUN.start_step(message["jobid"], message["name"])
    elif level == "job_finished":
        CURRENT_RUN.finish_step(message["jobid"])
        estimate = CURRENT_RUN.estimate_message()
        if estimate:
            print(estimate, file=sys.stderr, flush=True)
