"""Chooses the mesh whose flow is the answer: the coarsest whose estimated error is within the tolerance, else the best.

The meshes are solved from coarse to fine, each from the flow on the mesh before. A mesh without a flow is skipped if
another one has a flow. Where continuation is needed (solvers.continuation), it lowers an artificial viscosity eps. On
meshes before the last two it ends while eps is still large. Down to this eps a coarse mesh serves as well as a finer
one, at a third of the cost. If the best flow before the last mesh has an eps > 0, the last mesh is solved with this
eps.
"""

import pathlib
import sys
import time

import numpy as np

from common.errors import ComputationError
from flow.errors import error_estimate
from flow.physics import ffr
from flow.solvers.solved_mesh import CONVERGED, EFFORT_EARLY_STOP, EFFORT_FULL, EFFORT_GUESS_ONLY, solve_mesh


def tolerance_met(estimate, settings):
    """Whether the estimated error at `distal` is known and at most setting ffr_tolerance.

    estimate: result of errors.error_estimate.estimate_error, or None.
    """
    return estimate is not None and estimate["ffr"] <= settings.ffr_tolerance


def tolerance_warnings(estimate, settings, names=()):
    """Warnings on each probe whose error is not known to be within ffr_tolerance.

    The mesh is chosen for `distal` alone, so other probes may have larger errors. names: names of all probes, `distal`
    first.
    """
    quantity, above = "the error of FFR", f"above ffr_tolerance = {settings.ffr_tolerance:g}"
    found = []
    if estimate is None:
        found.append(f"{quantity} is not known: it may be {above}")
    elif not tolerance_met(estimate, settings):
        found.append(f"{quantity} is {estimate['ffr']:.3g}, {above}")
    for name, error in list(zip(names, estimate["probes"]))[1:] if estimate else ():
        if error > settings.ffr_tolerance:
            found.append(f"{quantity} at the probe {name} is {error:.3g}, {above}")
    return found


class MeshSearch:
    """The search for a flow in one lumen with an error of FFR of at most `settings.ffr_tolerance`.

    document: content of boundary.json; tree: geometry.centreline.Tree without extensions; predictor:
    reduced.coupled.Predictor. Results: meshes: one record for each mesh that was solved; factorizations: number made on
    all meshes; start_record: whether the start from another state led to a flow, None without such a start.
    """

    def __init__(self, document, settings, tree, predictor):
        self.document, self.settings, self.tree, self.predictor = document, settings, tree, predictor
        self.meshes, self.factorizations, self.start_record = [], 0, None

    def run(self, paths, start=None):
        """The SolvedMesh taken as the answer: the coarsest with an error within the tolerance, else the best one.

        paths: mesh files, the coarsest first. start: inputs.solution.StartState, the flow of another state of the
        vessel. The mesh with the name of that state's answer is solved first, from this flow. If that finds no flow,
        all meshes are solved in the usual way. Raises ComputationError where no mesh has a flow.
        """
        answer, remaining = self.solve_from_state(paths, start), paths
        if answer:
            if tolerance_met(answer.estimate, self.settings):
                return answer
            answer.problem.release()
            remaining = paths[paths.index(answer.path) + 1 :]
        for path in remaining:
            effort = (
                EFFORT_EARLY_STOP
                if path in paths[:-2]
                else EFFORT_GUESS_ONLY
                if answer and path == paths[-1]
                else EFFORT_FULL
            )
            try:
                solved = self.solve_on_mesh(path, answer, effort)
            except ComputationError as error:
                self.meshes.append({**self.record_failure(path, error), "status": "no flow"})
                if not answer and (path == paths[-1] or self.factorizations >= self.settings.max_newton_iterations):
                    raise
                print(f"{path}: no flow, another mesh answers:\n{error}", file=sys.stderr, flush=True)
                continue
            if answer:
                answer, other = (solved, answer) if _finer_is_better(solved, answer) else (answer, solved)
                other.destroy()
            else:
                answer = solved
            if tolerance_met(answer.estimate, self.settings):
                break
            answer.problem.release()  # frees the factors: memory may not hold those of two meshes
        print(f"{answer.path} answers", file=sys.stderr, flush=True)
        return answer

    def solve_from_state(self, paths, start):
        """Solves on the mesh of another state's answer, from that answer's flow, without artificial viscosity.

        start: as in `run`. The mesh is the one in `paths` with the same file name. Returns SolvedMesh, or None if
        Newton's method does not converge. Also returns None without a state, if its answer has an artificial viscosity,
        or if `paths` has no such mesh.
        """
        names = [pathlib.Path(path).name for path in paths]
        if start is None or start.artificial_viscosity > 0 or start.mesh_name not in names:
            return None
        path = paths[names.index(start.mesh_name)]
        try:
            solved = self.solve_on_mesh(path, None, EFFORT_FULL, start)
        except ComputationError as error:
            self.start_record = {**self.record_failure(path, error), "led_to_flow": False}
            print(f"{path}: no flow from that of the other state", file=sys.stderr, flush=True)
            return None
        factorizations = solved.problem.solver.factorizations
        self.start_record = {"mesh": start.mesh_name, "led_to_flow": True, "factorizations": factorizations}
        return solved

    def record_failure(self, path, error):
        """Counts the factorizations of a solve that ended with the ComputationError `error`.

        Returns its record {mesh, factorizations}. path: the mesh file.
        """
        factorizations = getattr(error, "factorizations", 0)
        self.factorizations += factorizations
        return {"mesh": pathlib.Path(path).name, "factorizations": factorizations}

    def solve_on_mesh(self, path, coarser, effort, start=None):
        """Solves on the mesh `path` and estimates the error. Returns SolvedMesh, raises ComputationError.

        The solve starts from `start`, else from `coarser` (SolvedMesh on another mesh), else from the reduced models or
        rest. The error estimate uses `coarser` too. effort: EFFORT_EARLY_STOP, EFFORT_FULL or EFFORT_GUESS_ONLY of
        solvers.solved_mesh.
        """
        begin, arguments = time.process_time(), (self.document, self.settings, self.tree, self.predictor)
        solved = solve_mesh(path, *arguments, coarser, self.factorizations, effort, start)
        solved.estimate = error_estimate.estimate_error(solved, self.document, self.tree, self.ffr_at_probes, coarser)
        self.factorizations += solved.problem.solver.factorizations
        solved.cpu_seconds = time.process_time() - begin
        self.meshes.append(self.mesh_record(solved))
        return solved

    def ffr_at_probes(self, sampler):
        """[FFR] at the probes, `distal` first."""
        return [probe["ffr"] for probe in ffr.at_probes(self.document, self.tree, sampler)]

    def mesh_record(self, solved):
        """Entry of `meshes` in ffr.json for a SolvedMesh. Also prints its FFR and estimated error."""
        value, estimate, name = self.ffr_at_probes(solved.sampler)[0], solved.estimate, pathlib.Path(solved.path).name
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


def _finer_is_better(finer, coarser):
    """Whether the flow on the finer mesh is the better answer (both SolvedMesh).

    Without artificial viscosity it is. Its estimate may then be the larger one, but only because it includes the change
    of FFR between the two meshes. With artificial viscosity it is better if its estimated error is not larger.
    """
    return finer.status == CONVERGED or _ffr_error(finer) <= _ffr_error(coarser)


def _ffr_error(solved):
    """Estimated error of FFR at `distal`; infinite where it is not known."""
    return solved.estimate["ffr"] if solved.estimate else np.inf
