"""Which mesh answers, and how: the coarse one first, steady where that is found, else marched in time.

A mesh whose own error is small and that keeps an eddy viscosity (c > 0, flow.fading) is marched in time: a finer mesh
would seldom find the steady flow either, at many times the cost. In a single tube the finer mesh comes first, where
the reduced models' flow may lead to a steady one. Where the last mesh gives no better answer the coarse one's is taken.
"""

import pathlib
import sys
import time

from common.errors import ComputationError
from flow import error_estimate, ffr, jet, linear_choice, locate, nonlinear, outlets, spaces, unsteady

# of an answer: steady flow; steady flow with c > 0, of a modified model; mean over time
CONVERGED, EDDY, UNSTEADY = STATUSES = ("converged", "converged with eddy viscosity", "unsteady")


class Solved:
    """One mesh with its flow: FlowProblem and its Outcome (None: no steady flow), error estimate, march."""

    def __init__(self, path, space, boundaries, problem, outcome):
        self.path, self.space, self.boundaries, self.problem, self.outcome = path, space, boundaries, problem, outcome
        self.mixing = problem.mixing  # c of the steady flow
        self.unsteady = None  # flow.unsteady.Answer where the flow is a mean
        self.estimate, self.marched, self.cpu_seconds = None, False, 0.0
        self.read()

    def read(self):
        """Takes the problem's state as the flow."""
        self.sampler = locate.FieldSampler(self.space, self.problem.state.x.array)
        self.outflows = self.boundaries.outflows(self.problem.state_vector())

    @property
    def known(self):
        """Whether this is a steady flow of the unmodified model whose error is estimated: an answer in itself."""
        return self.status == CONVERGED and self.outcome is not None and self.estimate is not None

    @property
    def status(self):
        """One of STATUSES."""
        if self.unsteady:
            return UNSTEADY
        return EDDY if self.problem.mixing > 0 else CONVERGED

    def destroy(self):
        self.problem.destroy()
        self.boundaries.destroy()


def within(estimate, settings):
    """Whether the error is known and estimated below the tolerance asked for."""
    return estimate is not None and estimate["ffr"] <= settings.ffr_tolerance


def missed(estimate, settings):
    """Warnings, printed too, where the error is not known to be within the tolerance asked for."""
    if within(estimate, settings):
        return []
    found = f"is {estimate['ffr']:.4f}, above" if estimate else "is not known: it may be above"
    said = f"the error of FFR {found} ffr_tolerance = {settings.ffr_tolerance:g}"
    print(said, file=sys.stderr, flush=True)
    return [said]


class Search:
    """The answer of one lumen to `settings.ffr_tolerance`.

    document: boundary.json; predicted: flow.predictor.Predictor; meshes: record of what was found on each mesh.
    """

    def __init__(self, document, settings, tree, predicted):
        self.document, self.settings, self.tree, self.predicted = document, settings, tree, predicted
        self.meshes, self.spent = [], 0

    def run(self, paths):
        """The Solved that answers, on the first mesh of `paths`, coarse first, that is good enough.

        The next mesh starts from the flow on the one before. A mesh that gives no flow is passed over while there are
        finer ones and factorizations left. Raises ComputationError.
        """
        before = None
        for path in paths:
            last = path == paths[-1]
            try:
                solved = self.on_mesh(path, before, last)
            except linear_choice.Refused:
                raise
            except ComputationError as error:
                self.spent += getattr(error, "factorizations", 0)
                if last and before:
                    print(f"{path}: no flow, the mesh before answers:\n{error}", file=sys.stderr, flush=True)
                    self.meshes.append({"mesh": pathlib.Path(path).name, "status": "no flow"})
                    solved, before = before, None
                    self.march(solved, None)
                    self.meshes.append(self.record(solved))
                    break
                if last or self.spent >= self.settings.max_newton_iterations:
                    raise
                print(f"{path}: no flow, a finer mesh is tried:\n{error}", file=sys.stderr, flush=True)
                self.meshes.append({"mesh": pathlib.Path(path).name, "status": "no steady flow"})
                continue
            if last and before and self.better(before, solved):
                solved, before = before, solved
            if before:
                before.destroy()
            if last or within(solved.estimate, self.settings):
                break
            before = solved
            before.problem.release()
        return solved

    def on_mesh(self, path, before, last):
        """Solved on a mesh, from the flow on the one before. Raises ComputationError."""
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
        self.meshes.append(self.record(solved))
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
            self.march(before, None)
            before.cpu_seconds += time.process_time() - begin
            self.meshes.append(self.record(before))
        if before.estimate is None or before.mixing > 0 and not before.unsteady:
            return False
        found = solved.estimate is None or before.estimate["ffr"] < solved.estimate["ffr"]
        if found:
            print(f"{before.path}: its error is the smaller, it answers", file=sys.stderr, flush=True)
        return found

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
            "linear_iterations": solved.problem.iterations,
            "cpu_seconds": solved.cpu_seconds,
        }


def solve_mesh(path, document, settings, tree, predicted, start=None, spent=0, march=False, near=False):
    """Solved from a mesh file; the guess is that of `start` (Solved on another mesh), else of `predicted` (Predictor).

    spent: factorizations already made of those allowed. march: where there is no steady flow Solved has no outcome.
    near: only a flow that Newton's method finds from `start` is wanted, and no large factorization where the iterative
    solver finds none. Raises ComputationError.
    """
    space = spaces.read(path)
    ffr.check_inside(document["probes"], tree, space)
    boundaries = outlets.Boundaries(space, document)
    jet_length = jet.mixing_length(space, tree, settings.jet_spread)
    given = space, boundaries, document, settings, jet_length, spent
    if linear_choice.iterates(space.dofs, start, settings):
        found = linear_choice.solve(given, start, path, near)
        if found:
            return Solved(path, space, boundaries, *found)
    problem = nonlinear.FlowProblem(*given)
    print(f"{path}: {space.dofs} dofs", file=sys.stderr, flush=True)
    network = predicted.network
    order = [network.names.index(name) for name in boundaries.names]

    def resistances_at(fraction):
        return network.resistances_at(predicted.flows, fraction)[order]

    try:
        if start is None:
            outcome = problem.solve(resistances_at, predicted)
        else:
            outcome = problem.solve_from_guess(start.problem, predicted, near or march and start.mixing > 0)
    except ComputationError as error:
        error.factorizations = problem.solver.factorizations
        if not march:
            problem.destroy()
            boundaries.destroy()
            raise
        print(f"{path}: no steady flow, marched in time:\n{error}", file=sys.stderr, flush=True)
        outcome = None
    return Solved(path, space, boundaries, problem, outcome)
