"""The answer where no steady flow is found: mean and amplitude of FFR over a window of the flow marched in time.

From the flow of least eddy viscosity the equations without any are marched (solvers.marching). The march is cut into
windows, the first of which is the start-up. It has settled when the mean FFR of two successive windows agrees; the
fields are then the mean over both. Where a window shows no more change than a steady flow would, Newton's method is
tried from there, and its flow is the answer, a steady one, where it converges. Otherwise the march ends with its steps,
and the flow is refused.
"""

import dataclasses

import numpy as np

from common.errors import ComputationError
from flow.geometry import locate
from flow.solvers import fading, marching, newton

STEP_ERROR = 3e-3  # of one step, over the root mean square of the velocity
FIRST_STEP, SHORTEST_STEP = 1e-4, 1e-7  # s
STEPS_IN_A_WINDOW = 20  # at least
SMALLEST_CHANGE, LARGEST_CHANGE = 0.4, 1.6  # of the step's length
WORTH_A_CHANGE = (0.8, 1.25)  # other factors are taken, for which the matrix is factorized anew
TIGHTEST = 1e-3  # what ffr_tolerance counts as where it is smaller
SETTLED = 0.5  # times the tolerance: difference of the means of two windows
QUIET = 0.1  # times the tolerance: change of FFR in a window below which Newton's method is tried


class Window:
    """Means over time of a problem's state and inflow, and of what `read` says; least and most of the latter."""

    def __init__(self, problem, read):
        self.problem, self.read = problem, read
        self.duration, self.steps = 0.0, 0
        self.state, self.inflow, self.values = 0.0, 0.0, 0.0
        self.low, self.high = np.inf, -np.inf
        self.last = None

    def take(self, dt):
        """Adds the present state, dt (s) after the one before, by the trapezoidal rule."""
        now = self.problem.state.x.array.copy(), self.problem.inflow, self.read()
        before = self.last or now
        self.state, self.inflow, self.values = (
            total + 0.5 * dt * (a + b) for total, a, b in zip((self.state, self.inflow, self.values), before, now)
        )
        self.low, self.high = np.minimum(self.low, now[2]), np.maximum(self.high, now[2])
        self.duration += dt
        self.steps += 1
        self.last = now

    def follow(self):
        """An empty window that begins where this one ends."""
        following = Window(self.problem, self.read)
        following.last = self.last
        return following

    @property
    def means(self):
        """Mean of what `read` says."""
        return self.values / self.duration

    def __str__(self):
        return f"FFR {self.means[0]:.4f}, {self.low[0]:.4f} to {self.high[0]:.4f} in the last {self.duration:.3g} s"


@dataclasses.dataclass
class Answer:
    """A settled march: window (s from its start), FFR of the probes' means and amplitudes, difference of its halves."""

    begin_s: float
    end_s: float
    steps: int
    factorizations: int
    means: np.ndarray
    amplitudes: np.ndarray
    difference: float

    def document(self):
        """Entry `unsteady` of ffr.json."""
        return {
            "window_s": [self.begin_s, self.end_s],
            "steps": self.steps,
            "factorizations": self.factorizations,
            "ffr_amplitude": float(self.amplitudes[0]),
            "half_windows_differ_by": self.difference,
        }


def march(problem, read):
    """Answer with the mean flow as the problem's state, or None with the steady flow as its state if one was found.

    read(sampler) -> FFR at the probes, `distal` first; sampler: geometry.locate.FieldSampler. Raises ComputationError
    where the march does not settle within settings.march_steps.
    """
    settings = problem.settings
    problem.boundaries.full()
    problem.forms.mixing.value = 0.0
    tolerance, before = max(settings.ffr_tolerance, TIGHTEST), problem.solver.factorizations
    sampler = locate.FieldSampler(problem.space, problem.state.x.array)

    def present():
        sampler.take(problem.space, problem.state.x.array)
        return np.asarray(read(sampler))

    stepper = marching.Stepper(problem)
    windows = []
    try:
        window = Window(problem, present)
        for dt in _lengths(stepper, settings.march_window_s / STEPS_IN_A_WINDOW, settings.march_steps):
            window.take(dt)
            if window.duration < settings.march_window_s:
                continue
            windows.append(window)
            print(f"{stepper.time:.4g} s in {stepper.steps} steps: {window}", file=problem.log, flush=True)
            quiet = window.high[0] - window.low[0] < QUIET * tolerance
            if quiet and _steady(problem, stepper):
                return None
            if not quiet and _agree(windows, SETTLED * tolerance):
                return _mean(problem, windows[-2:], stepper, problem.solver.factorizations - before)
            window = window.follow()
    finally:
        stepper.destroy()
    means = ", ".join(f"{window.means[0]:.4f}" for window in windows) or "none complete"
    raise ComputationError(
        "neither a steady flow nor a settled mean was found",
        f"{stepper.steps} steps, {stepper.time:.4g} s",
        f"mean FFR by window of {settings.march_window_s:g} s: {means}",
        "raise march_steps, march_window_s or rings",
    )


def _agree(windows, tolerance):
    """Whether the means of the last two windows do, the first of all windows not being among them."""
    return len(windows) > 2 and abs(windows[-1].means[0] - windows[-2].means[0]) <= tolerance


def _lengths(stepper, longest, most):
    """Steps with `stepper` and yields each step's length in s: such that its error is near STEP_ERROR."""
    dt, problem = FIRST_STEP, stepper.problem
    while stepper.steps < most:
        try:
            error = stepper.step(dt)
        except ComputationError:
            dt *= SMALLEST_CHANGE
            if dt < SHORTEST_STEP:
                raise
            continue
        yield dt
        if error is None:
            continue
        speed = float(np.sqrt(3 * np.mean(problem.state.x.array[problem.space.v_map] ** 2)))
        change = 0.9 * (STEP_ERROR * speed / max(error, 1e-300)) ** (1 / 3)
        if not WORTH_A_CHANGE[0] < change < WORTH_A_CHANGE[1]:
            dt = min(dt * np.clip(change, SMALLEST_CHANGE, LARGEST_CHANGE), longest)


def _steady(problem, stepper):
    """Whether Newton's method reaches a steady flow from here; if not the state stays."""
    values, inflow, settings = problem.state.x.array.copy(), problem.inflow, problem.settings
    stepper.pause()
    problem.allowed += fading.HARD
    found = newton.newton(problem, settings.residual_absolute, settings.residual_relative, fading.HARD)
    if found.converged:
        return True
    problem.state.x.array[:], problem.inflow = values, inflow
    stepper.resume()
    return False


def _mean(problem, windows, stepper, factorizations):
    """Answer over windows, their mean flow as the problem's state."""
    duration = sum(window.duration for window in windows)
    problem.state.x.array[:] = sum(window.state for window in windows) / duration
    problem.inflow = float(sum(window.inflow for window in windows) / duration)
    low = np.min([window.low for window in windows], axis=0)
    high = np.max([window.high for window in windows], axis=0)
    return Answer(
        stepper.time - duration,
        stepper.time,
        stepper.steps,
        factorizations,
        sum(window.values for window in windows) / duration,
        0.5 * (high - low),
        float(abs(windows[1].means[0] - windows[0].means[0])),
    )
