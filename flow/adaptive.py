"""Which mesh answers, and how: the coarse one first, steady where that is found, else marched in time.

A mesh whose own error is small and that keeps an eddy viscosity (c > 0, solvers.fading) is marched in time: a finer
mesh would seldom find the steady flow either, at many times the cost. In a single tube the finer mesh comes first,
where the reduced models' flow may lead to a steady one. Where the last mesh gives no better answer the coarse one's is
taken.
"""

import pathlib
import sys
import time

from common.errors import ComputationError
from flow.errors import error_estimate
from flow.physics import ffr
from flow.solvers import unsteady
from flow.solvers.solved_mesh import solve_mesh


def within(estimate, settings):
    """Whether the error is known and estimated below the tolerance asked for."""
    return estimate is not None and estimate["ffr"] <= settings.ffr_tolerance


def missed(estimate, settings, names=()):
    """Warnings, printed too, where the error is not known to be within the tolerance asked for: at `distal`, for which
    the mesh is chosen, and at the other probes; names: of all, `distal` first."""
    of, above = "the error of FFR", f"above ffr_tolerance = {settings.ffr_tolerance:g}"
    found = []
    if estimate is None:
        found.append(f"{of} is not known: it may be {above}")
    elif not within(estimate, settings):
        found.append(f"{of} is {estimate['ffr']:.3g}, {above}")
    for name, error in list(zip(names, estimate["probes"]))[1:] if estimate else ():
        if error > settings.ffr_tolerance:
            found.append(f"{of} at the probe {name} is {error:.3g}, {above}")
    for said in found:
        print(said, file=sys.stderr, flush=True)
    return found


class Search:
    """The answer of one lumen to `settings.ffr_tolerance`.

    document: boundary.json; predicted: reduced.coupled.Predictor; meshes: record of what was found on each mesh,
    each once.
    """

    def __init__(self, document, settings, tree, predicted):
        self.document, self.settings, self.tree, self.predicted = document, settings, tree, predicted
        self.meshes, self.spent = [], 0

    def run(self, paths):
        """The Solved that answers: on the first mesh of `paths`, coarse first, that is good enough, or the better one.

        The next mesh starts from the flow on the one before. A mesh that gives no flow is passed over while there are
        finer ones and factorizations left. Raises ComputationError.
        """
        before = None
        for path in paths:
            last = path == paths[-1]
            try:
                solved = self.on_mesh(path, before, last)
            except ComputationError as error:
                self.spent += getattr(error, "factorizations", 0)
                if last and before:
                    self.no_flow(path, error)
                    solved, before, begin = before, None, time.process_time()
                    self.march(solved, None)
                    if solved.marched:
                        solved.cpu_seconds += time.process_time() - begin
                        self.note(self.record(solved))
                    break
                if last or self.spent >= self.settings.max_newton_iterations:
                    raise
                print(f"{path}: no flow, a finer mesh is tried:\n{error}", file=sys.stderr, flush=True)
                self.note({"mesh": pathlib.Path(path).name, "status": "no steady flow"})
                continue
            if last and before and self.better(before, solved):
                solved, before = before, solved
            if last or within(solved.estimate, self.settings):
                break
            before = solved
            before.problem.release()
        if before:
            before.destroy()
        return solved

    def note(self, entry):
        """Takes an entry of `meshes`, in place of an earlier one of the same mesh."""
        names = [one["mesh"] for one in self.meshes]
        if entry["mesh"] in names:
            self.meshes[names.index(entry["mesh"])] = entry
        else:
            self.meshes.append(entry)

    def no_flow(self, path, error):
        """Says and records that a mesh gives no flow where there is an answer already."""
        print(f"{path}: no flow, the mesh before answers:\n{error}", file=sys.stderr, flush=True)
        self.note({"mesh": pathlib.Path(path).name, "status": "no flow"})

    def on_mesh(self, path, before, last):
        """Solved on a mesh, from the flow on the one before, with which its error is estimated too. Raises
        ComputationError."""
        begin, known = time.process_time(), before is not None and before.known
        may_march = last and self.settings.march_steps > 0 and not known
        solved = solve_mesh(
            path, self.document, self.settings, self.tree, self.predicted, before, self.spent, may_march, known
        )
        if solved.outcome:
            solved.estimate = error_estimate.of(solved, self.document, self.tree, self.at_probes, before)
        if (may_march or self.promising(solved)) and not within(solved.estimate, self.settings):
            self.march(solved, before)
        self.spent += solved.problem.solver.factorizations
        solved.cpu_seconds = time.process_time() - begin
        self.note(self.record(solved))
        return solved

    def promising(self, solved):
        """Whether a march on a mesh that is not the last is likely to answer within the tolerance."""
        settled = unsteady.SETTLED * self.settings.ffr_tolerance
        known = solved.estimate is not None and solved.problem.mixing > 0 and self.settings.march_steps > 0
        return (
            known
            and not self.predicted.whole
            and error_estimate.of_mesh(solved.estimate) + settled <= (self.settings.ffr_tolerance)
        )

    def march(self, solved, before):
        """Marches the flow of a Solved in time where it has eddy viscosity or is not steady; what the march ends with
        becomes the Solved's.

        Where the march does not settle the flow with eddy viscosity stays, with its estimate. Raises ComputationError
        where there is none.
        """
        problem = solved.problem
        if solved.marched or (solved.outcome and problem.mixing == 0):
            return
        kept = problem.state.x.array.copy(), problem.inflow, problem.mixing
        solved.marched = True
        try:
            solved.unsteady = unsteady.march(problem, self.at_probes)
        except ComputationError as error:
            if not solved.outcome:
                error.factorizations = problem.solver.factorizations
                solved.destroy()
                raise
            print(f"the flow with eddy viscosity is the answer:\n{error}", file=sys.stderr, flush=True)
            problem.state.x.array[:], problem.inflow, problem.forms.mixing.value = kept
            return
        settings, norm = problem.settings, problem.residual_norm()
        solved.outcome = problem.outcome(
            norm, settings.residual_absolute, settings.residual_relative, problem.solver.factorizations
        )
        solved.read()
        if solved.unsteady is None:
            solved.estimate = error_estimate.of(solved, self.document, self.tree, self.at_probes, before)
            return
        steady = solved if solved.estimate else before  # the last mesh's own steady flow may not be known
        if steady:
            solved.estimate = error_estimate.of_mean(steady.estimate, steady.mixing, solved.unsteady.difference)

    def better(self, before, solved):
        """Whether the mesh before, marched in time, answers with a smaller error than the last; it is marched so."""
        if within(solved.estimate, self.settings) or (solved.outcome and solved.mixing == 0 and not solved.unsteady):
            return False
        begin = time.process_time()
        if not before.marched and self.settings.march_steps > 0:
            solved.problem.release()  # both meshes' factors need not fit memory at once
            self.march(before, None)
            before.cpu_seconds += time.process_time() - begin
            self.note(self.record(before))
            if before.unsteady and solved.unsteady and self.of_two_means(solved, before):
                return False  # by the same difference the coarse mesh's error is the larger
        if before.estimate is None or before.mixing > 0 and not before.unsteady:
            return False
        found = solved.estimate is None or before.estimate["ffr"] < solved.estimate["ffr"]
        if found:
            print(f"{before.path}: its error is the smaller, it answers", file=sys.stderr, flush=True)
        return found

    def of_two_means(self, solved, before):
        """Takes the difference of both meshes' means for the error of the last's; whether it says anything."""
        estimate = error_estimate.of_two_means(solved, before, self.at_probes)
        if estimate:
            solved.estimate = estimate
            entry = next(one for one in self.meshes if one["mesh"] == pathlib.Path(solved.path).name)
            entry["error_estimate"] = estimate["ffr"]
            print(f"{solved.path}: by both means over time, error {estimate['ffr']:.4f}", file=sys.stderr, flush=True)
        return estimate is not None

    def at_probes(self, sampler):
        """FFR at the probes, `distal` first."""
        reference = ffr.reference_pa(self.document, self.tree, sampler)
        return [probe["ffr"] for probe in ffr.at_probes(self.document["probes"], self.tree, sampler, reference)]

    def distal(self, sampler):
        """FFR at the probe `distal`."""
        return self.at_probes(sampler)[0]

    def record(self, solved):
        """Entry of `meshes` in ffr.json, printed too."""
        value, estimate, name = self.distal(solved.sampler), solved.estimate, pathlib.Path(solved.path).name
        error = f", error {estimate['ffr']:.4f}" if estimate else ""
        print(f"{solved.path}: FFR {value:.4f}{error}", file=sys.stderr, flush=True)
        return {
            "mesh": name,
            "status": solved.status,
            "dofs": solved.space.dofs,
            "ffr": value,
            "error_estimate": estimate["ffr"] if estimate else None,
            "factorizations": solved.problem.solver.factorizations,
            "cpu_seconds": solved.cpu_seconds,
        }
