"""Snakemake log handler (config/profiles/local): says about every minute how long the run will still take.

An open step is expected to take the mean time of its rule's finished steps. If its rule has none, it takes the rule's
TYPICAL seconds, scaled by this run's speed so far. The sum is divided by the mean number of steps that ran at once. The
order of the steps is ignored, so the last minutes are underestimated.
"""

import collections
import re
import sys
import time

# Seconds of a step by rule: rough guesses for a patient of the cohort `nine` on an idle core. A guess is used until the
# first step of its rule has finished.
TYPICAL = {"flow_solve": 60, "flow_mesh": 15, "reference": 60, "ct_phantom": 15, "ct_segment": 20, "other_plans": 70}
TYPICAL |= {"deploy": 8, "ct_deploy": 8, "generate": 8, "case_figures": 10, "ct_figure": 5, "procedure_figure": 8}
TYPICAL |= {"half_maximum_segment": 20, "half_maximum_deploy": 8}
TYPICAL |= {"flow_sensitivity": 8, "settings": 0, "all": 0}
OTHERS = 3  # seconds of any other rule
EVERY_S, FEWEST = 60.0, 10  # seconds between two estimates; finished steps before the first


class TimeLeft:
    """Counts a run's finished and open steps. clock: function that returns seconds."""

    def __init__(self, clock=time.monotonic):
        self.clock, self.begin, self.said = clock, clock(), clock()
        self.planned, self.started = collections.Counter(), {}
        self.count, self.seconds = collections.Counter(), collections.Counter()

    def plan(self, table):
        """Reads the table of jobs that Snakemake prints. A line has rule, number of jobs, least and most threads."""
        for line in table.splitlines():
            found = re.match(r"(\w+)\s+(\d+)\s+\d+\s+\d+$", line.strip())
            if found and found[1] != "total":
                self.planned[found[1]] = int(found[2])

    def start(self, job, rule):
        """Notes that a step has begun."""
        self.started[job] = rule, self.clock()

    def finish(self, job):
        """Notes that a step has ended."""
        if job in self.started:
            rule, begin = self.started.pop(job)
            self.count[rule] += 1
            self.seconds[rule] += self.clock() - begin

    def left_s(self):
        """Seconds until the run ends; None before FEWEST steps have finished."""
        finished, busy = sum(self.count.values()), sum(self.seconds.values())
        if finished < FEWEST or not busy:
            return None
        known = [rule for rule in self.count if TYPICAL.get(rule, OTHERS)]
        usual = sum(self.count[rule] * TYPICAL.get(rule, OTHERS) for rule in known)
        slower = sum(self.seconds[rule] for rule in known) / usual if usual else 1.0
        at_once = max(1.0, busy / (self.clock() - self.begin))
        return sum(self._expected(rule, slower) * self._open(rule) for rule in self.planned) / at_once

    def _open(self, rule):
        return max(0, self.planned[rule] - self.count[rule])

    def _expected(self, rule, slower):
        if self.count[rule]:
            return self.seconds[rule] / self.count[rule]
        return slower * TYPICAL.get(rule, OTHERS)

    def words(self):
        """The sentence to print if an estimate is due, else None."""
        left = self.left_s()
        if left is None or self.clock() - self.said < EVERY_S:
            return None
        self.said = self.clock()
        return f"about {duration(left)} left, by the {sum(self.count.values())} steps done so far"


def duration(seconds):
    """A duration in words: 40 s, 12 min, 2 h 05 min."""
    minutes = round(seconds / 60)
    if minutes < 1:
        return f"{seconds:.0f} s"
    return f"{minutes} min" if minutes < 60 else f"{minutes // 60} h {minutes % 60:02d} min"


RUN = TimeLeft()


def log_handler(message):
    """Called by Snakemake with each of its log messages (a dict)."""
    level = message["level"]
    if level == "run_info":
        RUN.plan(message["msg"])
    elif level == "job_info":
        RUN.start(message["jobid"], message["name"])
    elif level == "job_finished":
        RUN.finish(message["jobid"])
        words = RUN.words()
        if words:
            print(words, file=sys.stderr, flush=True)
