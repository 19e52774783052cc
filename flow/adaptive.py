"""Which mesh answers: the first, coarse first, whose estimated error is within the tolerance, else the best of them.

Each mesh starts from the flow on the one before. A mesh on which no flow is found is passed over where another answers.
On meshes before the last two continuation ends while the artificial viscosity is still large: so far they serve as well
as a finer mesh, for a third of the cost. The last mesh keeps the eps of the best flow before, if that has any.
"""

import pathlib
import sys
import time

import numpy as np

from common.errors import ComputationError
from flow.errors import error_estimate
from flow.physics import ffr
from flow.solvers.solved_mesh import BEGUN, CONVERGED, NEAR, WHOLE, solve_mesh


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
    each once; started: what became of the start from another state, None where there was none.
    """

    def __init__(self, document, settings, tree, predicted):
        self.document, self.settings, self.tree, self.predicted = document, settings, tree, predicted
        self.meshes, self.spent, self.started = [], 0, None

    def run(self, paths, start=None):
        """The Solved that answers: on the first mesh of `paths`, coarse first, that is good enough, or the better one.

        start: inputs.solution.Start, the flow of another state of the vessel. The mesh of the same place in the
        sequence as the one that answered there is solved from it; where that finds no flow all go the usual way.
        Raises ComputationError where no mesh has a flow.
        """
        answer, left = self.from_state(paths, start), paths
        if answer:
            if within(answer.estimate, self.settings):
                return answer
            answer.problem.release()
            left = paths[paths.index(answer.path) + 1 :]
        for path in left:
            effort = BEGUN if path in paths[:-2] else NEAR if answer and path == paths[-1] else WHOLE
            try:
                solved = self.on_mesh(path, answer, effort)
            except ComputationError as error:
                made = getattr(error, "factorizations", 0)
                self.spent += made
                self.meshes.append({"mesh": pathlib.Path(path).name, "status": "no flow", "factorizations": made})
                if not answer and (path == paths[-1] or self.spent >= self.settings.max_newton_iterations):
                    raise
                print(f"{path}: no flow, another mesh answers:\n{error}", file=sys.stderr, flush=True)
                continue
            if answer:
                answer, other = (solved, answer) if _better(solved, answer) else (answer, solved)
                other.destroy()
            else:
                answer = solved
            if within(answer.estimate, self.settings):
                break
            answer.problem.release()  # two meshes' factors need not fit the memory at once
        print(f"{answer.path} answers", file=sys.stderr, flush=True)
        return answer

    def from_state(self, paths, start):
        """Solved from the flow of another state, without artificial viscosity.

        None where no state is given, where that state kept an artificial viscosity, or where Newton's method does not
        converge from it.
        """
        names = [pathlib.Path(path).name for path in paths]
        if start is None or start.artificial > 0 or start.mesh not in names:
            return None
        path = paths[names.index(start.mesh)]
        try:
            solved = self.on_mesh(path, None, WHOLE, start)
        except ComputationError as error:
            made = getattr(error, "factorizations", 0)
            self.spent += made
            self.started = {"mesh": start.mesh, "led_to_flow": False, "factorizations": made}
            print(f"{path}: no flow from that of the other state", file=sys.stderr, flush=True)
            return None
        made = solved.problem.solver.factorizations
        self.started = {"mesh": start.mesh, "led_to_flow": True, "factorizations": made}
        return solved

    def on_mesh(self, path, before, effort, start=None):
        """Solved on a mesh, from the flow on the one before, with which its error is estimated too, or from that of
        another state; effort: as solvers.solved_mesh has it. Raises ComputationError."""
        begin, case = time.process_time(), (self.document, self.settings, self.tree, self.predicted)
        solved = solve_mesh(path, *case, before, self.spent, effort, start)
        solved.estimate = error_estimate.of(solved, self.document, self.tree, self.at_probes, before)
        self.spent += solved.problem.solver.factorizations
        solved.cpu_seconds = time.process_time() - begin
        self.meshes.append(self.record(solved))
        return solved

    def at_probes(self, sampler):
        """FFR at the probes, `distal` first."""
        return [probe["ffr"] for probe in ffr.at_probes(self.document, self.tree, sampler)]

    def record(self, solved):
        """Entry of `meshes` in ffr.json, printed too."""
        value, estimate, name = self.at_probes(solved.sampler)[0], solved.estimate, pathlib.Path(solved.path).name
        error = f", error {estimate['ffr']:.4f}" if estimate else ""
        print(f"{solved.path}: FFR {value:.4f}{error}", file=sys.stderr, flush=True)
        return {
            "mesh": name,
            "status": solved.status,
            "dofs": solved.space.dofs,
            "ffr": value,
            "error_estimate": estimate["ffr"] if estimate else None,
            **{name: estimate[name] for name in ("goal_signed", "goal_sizes") if name in (estimate or {})},
            "factorizations": solved.problem.solver.factorizations,
            "cpu_seconds": solved.cpu_seconds,
        }


def _better(finer, coarser):
    """Whether the finer mesh's flow answers: it does where it is one without artificial viscosity, as its estimate
    knows more, and else by its estimate."""
    return finer.status == CONVERGED or _error(finer) <= _error(coarser)


def _error(solved):
    """Estimated error of FFR at `distal`; infinite where it is not known."""
    return solved.estimate["ffr"] if solved.estimate else np.inf
