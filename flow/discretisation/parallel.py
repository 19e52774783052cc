"""Several MPI ranks on one solve: all go the same way with the same numbers and share what costs most.

Every rank holds the whole mesh and flow and takes every decision; the matrix is assembled, factorized and solved with
by rows, residuals are summed over the ranks' cells, the patches of the error estimate and the check of the cells are
shared out. So the answer is that of one rank but for rounding. One rank alone runs the same code. Files are written by
the first rank.
"""

import contextlib
import os
import shutil
import sys
import traceback

import numpy as np

from common.errors import InputError, UserError

LAUNCHED = ("OMPI_COMM_WORLD_SIZE", "PMI_SIZE")  # set by mpirun


def launched():
    """Whether mpirun started this."""
    return any(name in os.environ for name in LAUNCHED)


def launch(ranks, command):
    """Becomes mpirun with `ranks` ranks of `python3 -m flow` with the arguments `command`, unless it is one already.

    Raises InputError where there is no mpirun, and for more ranks than cores: each waits for the others busily.
    """
    if ranks == 1 or launched():
        return
    if ranks > os.cpu_count():
        raise InputError(
            "more ranks than cores", "ranks", ranks, f"at most {os.cpu_count()} here; the answer is the same"
        )
    program = shutil.which("mpirun")
    if program is None:
        raise InputError("no mpirun", "ranks", ranks, "install openmpi-bin, or ask for one rank")
    options = ["--oversubscribe", "-n", str(ranks)]
    if os.geteuid() == 0:
        options.insert(0, "--allow-run-as-root")
    sys.stdout.flush()
    sys.stderr.flush()
    os.execv(program, [program, *options, sys.executable, "-m", "flow", *command])


def check(ranks):
    """Raises InputError where other than the `ranks` asked for run: of a launcher that this MPI does not know each
    process is alone. Without a wish (1) as many as there are share the work."""
    found = world().size
    if ranks not in (1, found):
        remedy = f"start it with `mpirun -n {ranks}`, or outside of mpirun and srun"
        raise InputError("other ranks run than asked for", "ranks", f"{ranks} asked for, {found} run", remedy)


def world():
    """The communicator of all ranks."""
    from mpi4py import MPI

    return MPI.COMM_WORLD


def first():
    """Whether this is the rank that writes and speaks."""
    return world().rank == 0


@contextlib.contextmanager
def together():
    """The other ranks are silent from here on; an error that is not a UserError ends all ranks: they would wait for
    ever."""
    comm, said = world(), sys.stderr
    if comm.rank > 0:
        sys.stdout = sys.stderr = open(os.devnull, "w")
    try:
        yield
    except UserError:
        raise
    except BaseException:
        if comm.size == 1:
            raise
        traceback.print_exc(file=said)
        comm.Abort(1)


def from_first(work):
    """What `work()` returns on the first rank, on all; its UserError is raised on all."""
    found = failure = None
    if first():
        try:
            found = work()
        except UserError as error:
            failure = type(error), (error.what, error.where, str(error.value), error.remedy)
    found, failure = world().bcast((found, failure))
    if failure:
        kind, parts = failure
        raise kind(*parts)
    return found


def share(count):
    """(first, one past the last) of `count` things that are this rank's."""
    comm = world()
    return comm.rank * count // comm.size, (comm.rank + 1) * count // comm.size


def shares(count):
    """How many of `count` things each rank has."""
    size = world().size
    return np.diff([rank * count // size for rank in range(size + 1)])


def collected(own, count):
    """(count,) of all ranks' values (n,), each rank's at its share."""
    comm = world()
    if comm.size == 1:
        return own
    everything = np.empty(count)
    comm.Allgatherv(np.ascontiguousarray(own), (everything, shares(count)))
    return everything


def total(values):
    """Sum of arrays or numbers over the ranks, on each."""
    return world().allreduce(values)
