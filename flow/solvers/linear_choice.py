"""Which linear solver a mesh gets: MUMPS (solvers.linear), or the iterative one (solvers.iterative) with a coarse mesh.

Where the iterative solver finds no flow, MUMPS takes over if its factors fit the memory that is free; else the solve is
refused.
"""

import sys

from common.errors import ComputationError, InputError
from flow.discretisation import parallel
from flow.solvers import fading, iterative

LARGE = 200_000  # dofs, from which the iterative solver takes less CPU time or memory than MUMPS (flow/measured.md)
MEASURED_DOFS, MEASURED_MIB, POWER = 245_637, 3379, 1.5  # MUMPS' factors, and how they grow with the dofs
MEMORY = "/proc/meminfo"
MOST_MIB = 4096  # of factors, where there is an answer already


class Refused(ComputationError):
    """The mesh that was asked for cannot be solved on: no other answers in its place."""


def iterates(dofs, start, settings):
    """Whether a mesh of so many dofs is solved iteratively from `start`, a solvers.solved_mesh.Solved of a coarser
    one, or None: not where that has kept an eddy viscosity, since other starts and the march ask for factorizations."""
    steady = start is not None and start.outcome is not None and start.unsteady is None and start.mixing == 0
    if settings.linear_solver == "auto":
        return steady and dofs > LARGE and parallel.world().size == 1
    return settings.linear_solver == "iterative" and steady


def check(paths, settings):
    """Raises InputError where the iterative solver is asked for without a coarse mesh."""
    if settings.linear_solver == "iterative" and len(paths) < 2:
        raise InputError(
            "the iterative solver needs a coarse mesh", "linear_solver", "iterative", "give --coarse, or direct"
        )


def factors_mib(dofs):
    """Memory in MiB that MUMPS takes for a mesh of so many dofs."""
    return MEASURED_MIB * (dofs / MEASURED_DOFS) ** POWER


def most_dofs(start, settings):
    """Unknowns that a mesh which is made for a solve from `start` may have: `most_dofs` of the settings, no more than
    whose factors fit MOST_MIB and the free memory where they are factorized."""
    if iterates(settings.most_dofs, start, settings):
        return settings.most_dofs
    fitting = MEASURED_DOFS * (min(MOST_MIB, free_mib()) / MEASURED_MIB) ** (1 / POWER)
    return min(settings.most_dofs, int(fitting))


def free_mib():
    """Memory in MiB that is free."""
    with open(MEMORY) as file:
        values = dict(line.split(":") for line in file)
    return int(values["MemAvailable"].split()[0]) / 1024


def solve(given, start, path, only=False):
    """(IterativeProblem, Outcome) of the flow from `start`, or None where MUMPS is to be asked.

    given: the arguments of FlowProblem up to `spent`. Raises Refused where it finds none and MUMPS is out of the
    question, for want of memory or because it was not asked for; with `only`, `start` being an answer too, its
    ComputationError where the factors would be large.
    """
    space, settings = given[0], given[3]
    problem = iterative.IterativeProblem(*given, start.problem)
    print(f"{path}: {space.dofs} dofs, iterative solver", file=sys.stderr, flush=True)
    try:
        problem.boundaries.full()
        problem.set_guess(start.space, start.problem.state.x.array, start.problem.inflow)
        return problem, fading.from_guess(problem, start.problem.mixing, True)
    except ComputationError as error:
        problem.destroy()
        if only and settings.linear_solver == "auto" and factors_mib(space.dofs) > MOST_MIB:
            raise
        if settings.linear_solver == "iterative" or factors_mib(space.dofs) > free_mib():
            raise Refused(error.what, error.where, error.value, error.remedy) from error
        print(f"{path}: by factorization, since the iterative solver failed:\n{error}", file=sys.stderr, flush=True)
        return None
