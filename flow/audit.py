"""Is the steady flow the mean of the flow in time? `flow audit` answers this for the flow that `flow solve` would find.

The flow is marched in time (solvers.marching) from the disturbed steady flow, without artificial viscosity. Without a
disturbance a steady flow would stay as it is, even if it is unstable. The time unit is D/U at the probe `distal`: the
vessel's diameter over its mean velocity. The start-up is cut off where the standard error of the rest is least (MSER,
White 1997, Simulation 69). The rest is divided into BATCHES equal batches. Their means give Student's interval of 95 %
(batch means; Law and Kelton, Simulation Modeling and Analysis). The audit shows whether the steady FFR lies within the
tolerance of the mean.
"""

import sys

import numpy as np
import pandas
import scipy.stats

from common.errors import ComputationError
from flow.physics import ffr
from flow.solvers import marching

STEP_ERROR = 3e-3  # wanted error of one step, over the root mean square of the velocity
FIRST_STEP, SHORTEST_STEP = 1e-4, 1e-7  # s: the first step, and the shortest that is tried
# The longest step in time units D/U. With steps of 0.1 the method damps the oscillations of a jet.
LONGEST_STEP = 0.02
SMALLEST_CHANGE, LARGEST_CHANGE = 0.4, 1.6  # limits of a step's length over the length of the step before
# The length is kept if the wanted factor lies between these, as each change costs a factorization.
NEGLIGIBLE_CHANGE = (0.8, 1.25)
SAMPLES_PER_UNIT = 10  # number of evenly spaced samples of the series in a time unit
DISTURBANCE = 0.1  # amplitude of each of the three waves that the velocities are multiplied by at the start
BATCHES = 8  # number of batches into which the series is divided after the start-up
CONFIDENCE = 0.95  # probability that the interval given for a mean holds the true mean


def time_unit(radius_mm, flow_m3_per_s):
    """D/U in s: diameter over mean velocity of a flow through a round vessel."""
    return np.pi * (2e-3 * radius_mm) ** 3 / (4 * flow_m3_per_s)


def disturb(problem, wavelength_m):
    """Multiplies the velocities, but for those at the inlet, by 1 plus a wave of this length along each axis."""
    space, values = problem.space, problem.state.x.array
    inlet = values[space.inlet_dofs]
    waves = np.sin(2 * np.pi / wavelength_m * space.V.tabulate_dof_coordinates() + np.arange(3)).sum(axis=1)
    values[space.v_map] *= np.repeat(1 + DISTURBANCE * waves, 3)
    values[space.inlet_dofs] = inlet


def march(problem, read_ffr, unit_s, units, most_steps):
    """Marches the flow in time and returns a DataFrame with time_s and ffr_0, ffr_1, ... of the probes.

    problem: solvers.nonlinear.FlowProblem, whose present flow is the start; read_ffr(sampler) -> FFR at the probes. The
    march ends after `units` time units of unit_s, or after `most_steps` steps. Raises ComputationError where even a
    step of about SHORTEST_STEP fails.
    """
    problem.boundaries.set_full_flow()
    problem.forms.artificial_viscosity.value = 0.0
    stepper, rows = marching.Stepper(problem), []

    def record():
        rows.append([stepper.time, *read_ffr(problem.space.sampler(problem.state.x.array))])

    try:
        record()
        for dt in _march_adaptively(stepper, LONGEST_STEP * unit_s, most_steps):
            record()
            if stepper.steps % 20 == 0:
                progress = (
                    f"{stepper.time / unit_s:.2f} of {units:g} D/U in {stepper.steps} steps: FFR {rows[-1][1]:.4f}"
                )
                print(f"{progress}, step {dt:.2g} s", file=sys.stderr, flush=True)
            if stepper.time >= units * unit_s:
                break
    finally:
        factorizations = problem.solver.factorizations
        stepper.destroy()
    table = pandas.DataFrame(rows, columns=["time_s", *(f"ffr_{k}" for k in range(len(rows[0]) - 1))])
    table.attrs["factorizations"] = factorizations
    return table


def _march_adaptively(stepper, longest_step, most_steps):
    """Makes up to `most_steps` steps with a marching.Stepper and yields the length of each in s.

    The lengths are chosen for an error near STEP_ERROR, and are at most `longest_step` in s.
    """
    dt, problem = min(FIRST_STEP, longest_step), stepper.problem
    while stepper.steps < most_steps:
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
        if not NEGLIGIBLE_CHANGE[0] < change < NEGLIGIBLE_CHANGE[1]:
            dt = min(dt * np.clip(change, SMALLEST_CHANGE, LARGEST_CHANGE), longest_step)


def start_up_samples(values):
    """Number of samples at the start of a series `values` (n,) that MSER cuts off.

    With this number cut off, the variance of the rest over its length is least. It is at most half the series, since
    the variance of few samples is often small by chance.
    """
    values = values - values.mean()  # limits rounding errors in the difference of squares below
    rest = np.arange(len(values), 0, -1)
    sums, squares = (np.cumsum(part[::-1])[::-1] for part in (values, values**2))
    variance = squares / rest - (sums / rest) ** 2
    return int(np.argmin((variance / rest)[: len(values) // 2 + 1]))


def batch_means(values):
    """(mean, half width of its CONFIDENCE interval) of a series (n,), from the means of BATCHES batches."""
    size = len(values) // BATCHES
    means = values[len(values) - BATCHES * size :].reshape(BATCHES, size).mean(axis=1)
    half = scipy.stats.t.ppf(0.5 + CONFIDENCE / 2, BATCHES - 1) * means.std(ddof=1) / np.sqrt(BATCHES)
    return float(means.mean()), float(half)


def audit_document(table, unit_s, steady, tolerance):
    """Document of audit.json from the table of `march`.

    unit_s: time unit; steady: FFR of the steady flow at the probes, `distal` first; tolerance: largest accepted
    difference of FFR. `settled` in the document: whether the half width of the mean's interval is within the tolerance.
    A flow still in its start-up has not settled, since the means of its batches are far apart. `agrees`: whether the
    steady FFR is within the tolerance of every value in that interval; None where the march did not settle.
    """
    times = table["time_s"].to_numpy()
    even_times = np.linspace(0.0, times[-1], max(int(SAMPLES_PER_UNIT * times[-1] / unit_s), 2 * BATCHES) + 1)[1:]
    series = [np.interp(even_times, times, table[f"ffr_{k}"]) for k in range(len(steady))]
    cut = start_up_samples(series[0])
    found = [batch_means(values[cut:]) for values in series]
    settled = found[0][1] <= tolerance
    gap = steady[0] - found[0][0]
    return {
        "schema": "vci-audit-1",
        "ffr_steady": float(steady[0]),
        "ffr_mean": found[0][0],
        "ffr_mean_half_width_95": found[0][1],
        "steady_minus_mean": float(gap),
        "settled": bool(settled),
        "agrees": bool(abs(gap) + found[0][1] <= tolerance) if settled else None,
        "ffr_tolerance": tolerance,
        "ffr_least": float(series[0][cut:].min()),
        "ffr_most": float(series[0][cut:].max()),
        "time_unit_s": unit_s,
        "time_units": float(times[-1] / unit_s),
        "start_up_units": float(even_times[cut - 1] / unit_s) if cut else 0.0,
        "batches": BATCHES,
        "steps": len(times) - 1,
        "factorizations": table.attrs["factorizations"],
        "probes": [
            {"ffr_steady": float(value), "ffr_mean": mean, "half_width_95": half}
            for value, (mean, half) in zip(steady, found)
        ],
    }


def audit_answer(solved, case):
    """(document of audit.json, table of `march`) for a solvers.solved_mesh.SolvedMesh.

    The march changes the flow of `solved`. case: reduced.extended.ExtendedLumen.
    """

    def read_ffr(sampler):
        return [one["ffr"] for one in ffr.at_probes(case.document, case.original_tree, sampler)]

    flow_of = dict(zip(solved.boundaries.outlet_names, solved.outflows))
    network = case.network
    branch, s_mm, _ = case.original_tree.project_probe(case.document["probes"][0])
    flow = sum(flow_of[network.outlet_names[i]] for i in network.downstream(branch.name, s_mm))
    unit_s, steady = float(time_unit(branch.radius(s_mm), flow)), read_ffr(solved.sampler)
    disturb(solved.problem, 2e-3 * branch.radius(s_mm))
    table = march(solved.problem, read_ffr, unit_s, case.settings.audit_units, case.settings.march_steps)
    answer = audit_document(table, unit_s, steady, case.settings.ffr_tolerance)
    answer["artificial_viscosity"] = solved.artificial_viscosity
    return answer, table


def summary_line(answer):
    """One line for the user with the result in the document of audit.json."""
    mean = f"mean {answer['ffr_mean']:.4f} +- {answer['ffr_mean_half_width_95']:.4f}"
    over = f"{answer['time_units']:.1f} D/U"
    if not answer["settled"]:
        return f"not settled within {over}: {mean}"
    return f"steady FFR {answer['ffr_steady']:.4f}, {mean} over {over}"
