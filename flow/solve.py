"""A solve from files to files: reduced model, coarse mesh, fine mesh where the error asks for it, FFR and its error."""

import pathlib
import resource
import sys
import time

import numpy as np

from common.errors import ComputationError
from flow import (
    energy,
    error_estimate,
    ffr,
    jet,
    locate,
    nonlinear,
    outlets,
    output,
    predictor,
    reduced_answer,
    spaces,
    unsteady,
    viscosity,
    wall_shear,
)

LARGE = 0.05  # difference of the models' FFR that is said


class Solved:
    """One mesh with its solution."""

    def __init__(self, space, boundaries, problem, outcome):
        self.space, self.boundaries, self.problem, self.outcome = space, boundaries, problem, outcome
        self.unsteady = None  # flow.unsteady.Answer where the flow is a mean
        self.read()

    def read(self):
        """Takes the problem's state as the flow."""
        self.sampler = locate.FieldSampler(self.space, self.problem.state.x.array)
        self.outflows = self.boundaries.outflows(self.problem.state_vector())

    def destroy(self):
        self.problem.destroy()
        self.boundaries.destroy()


def solve_mesh(path, document, settings, tree, predicted, start=None, spent=0, march=False):
    """Solved from a mesh file; the guess is that of `start` (Solved on another mesh), else of `predicted` (Predictor).

    spent: factorizations already made of those allowed. march: where there is no steady flow Solved has no outcome.
    """
    space = spaces.read(path)
    boundaries = outlets.Boundaries(space, document)
    jet_length = jet.mixing_length(space, tree, settings.jet_spread)
    problem = nonlinear.FlowProblem(space, boundaries, document, settings, jet_length, spent)
    print(f"{path}: {space.dofs} dofs", file=sys.stderr, flush=True)
    network = predicted.network
    order = [network.names.index(name) for name in boundaries.names]

    def resistances_at(fraction):
        return network.resistances_at(predicted.flows, fraction)[order]

    try:
        if start is None:
            outcome = problem.solve(resistances_at, predicted)
        else:
            outcome = problem.solve_from_guess(start.problem, predicted)
    except ComputationError as error:
        error.factorizations = problem.solver.factorizations
        if not march:
            problem.destroy()
            boundaries.destroy()
            raise
        print(f"{path}: no steady flow, marched in time:\n{error}", file=sys.stderr, flush=True)
        outcome = None
    return Solved(space, boundaries, problem, outcome)


def run(mesh, coarse, document, tree, network, settings, folder):
    """Solves and writes solution.vtu, pullback.csv and ffr.json to `folder`; returns the document of ffr.json."""
    begin, begin_cpu = time.perf_counter(), time.process_time()
    paths = [path for path in (coarse, mesh) if path]
    predicted = predictor.Predictor(network, tree, document, settings)
    models = predicted.answers()
    print(f"1D network: FFR {models['network']['ffr']:.4f}", file=sys.stderr, flush=True)
    if settings.model == "3d":
        solved, estimate, meshes = to_tolerance(paths, document, settings, tree, predicted)
        reference = ffr.reference_pa(document, tree, solved.sampler)
        probes = ffr.at_probes(document["probes"], tree, solved.sampler, reference)
        answer, table = collect(solved, probes, tree, network, reference)
        models["3d"] = {"ffr": answer["ffr"], "error_estimate": estimate["ffr"] if estimate else None}
        answer["error_estimate"] = estimate
        answer["ffr_tolerance"] = settings.ffr_tolerance
        answer["tolerance_met"] = within(estimate, settings)
        answer["meshes"] = meshes
    else:
        if settings.model == "network":
            predicted.uncouple()
        solved = reduced_answer.Reduced(predicted, paths[0])
        reference = ffr.reference_pa(document, tree, solved.sampler)
        answer, table = reduced_answer.collect(settings.model, predicted, solved, document, reference)
    answer["models"], answer["warnings"] = models, compared(models) + ffr.rising(answer["probes"], table)
    answer["reduced_model"] = {"model": "1D network", **models["network"]}
    answer["seconds"] = time.perf_counter() - begin
    answer["cpu_seconds"] = time.process_time() - begin_cpu
    answer["peak_memory_mib"] = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024
    output.write_all(pathlib.Path(folder), fields(solved, document, reference), table, answer)
    solved.destroy()
    predicted.destroy()
    return answer


def compared(models):
    """Warnings, printed too, where the models' FFR differ by more than LARGE."""
    found = {name: entry["ffr"] for name, entry in models.items() if entry["ffr"] is not None}
    if max(found.values()) - min(found.values()) <= LARGE:
        return []
    values = ", ".join(f"{name} {value:.3f}" for name, value in found.items())
    said = f"the models' FFR differ by more than {LARGE:g}: {values}; look at the mesh and sections.csv"
    print(said, file=sys.stderr, flush=True)
    return [said]


def within(estimate, settings):
    """Whether the error is known and estimated below the tolerance asked for."""
    return estimate is not None and estimate["ffr"] <= settings.ffr_tolerance


def to_tolerance(paths, document, settings, tree, predicted):
    """(Solved, error estimate, record of the meshes) on the first mesh of `paths`, coarse first, that is good enough.

    The next mesh starts from the flow on the one before. A mesh that gives no flow is passed over while there are finer
    ones and factorizations left. Raises ComputationError.
    """
    before, meshes, spent = None, [], 0
    for path in paths:
        last, begin = path == paths[-1], time.process_time()
        try:
            march = last and settings.march_steps > 0
            solved = solve_mesh(path, document, settings, tree, predicted, before, spent, march)
        except ComputationError as error:
            spent += error.factorizations
            if last or spent >= settings.max_newton_iterations:
                raise
            print(f"{path}: no flow, a finer mesh is tried:\n{error}", file=sys.stderr, flush=True)
            meshes.append({"mesh": pathlib.Path(path).name, "status": "no steady flow"})
            continue

        def at_probes(sampler):
            reference = ffr.reference_pa(document, tree, sampler)
            return [probe["ffr"] for probe in ffr.at_probes(document["probes"], tree, sampler, reference)]

        def distal(sampler):
            return at_probes(sampler)[0]

        estimate = error_estimate.of(solved, document, tree, distal, before) if solved.outcome else None
        if march and (solved.problem.mixing > 0 or not solved.outcome) and not within(estimate, settings):
            estimate = march_on(solved, document, tree, at_probes, before, estimate)
        spent += solved.problem.solver.factorizations
        meshes.append(_record(path, solved, distal(solved.sampler), estimate, time.process_time() - begin))
        if before:
            before.destroy()
        if last or within(estimate, settings):
            break
        before = solved
        before.problem.solver.release()
    if not within(estimate, settings):
        print(f"error of FFR not known to be below ffr_tolerance = {settings.ffr_tolerance:g}", file=sys.stderr)
    return solved, estimate, meshes


def march_on(solved, document, tree, at_probes, before, estimate):
    """Error estimate of the flow that a march in time from that of a Solved ends with, which becomes the Solved's.

    at_probes(sampler) -> FFR at the probes. Where the march does not settle the flow with eddy viscosity stays, and
    its `estimate`. Raises ComputationError where there is none.
    """
    problem, kept = solved.problem, (solved.problem.state.x.array.copy(), solved.problem.inflow, solved.problem.mixing)
    try:
        solved.unsteady = unsteady.march(problem, at_probes)
    except ComputationError as error:
        if not solved.outcome:
            raise
        print(f"the flow with eddy viscosity is the answer:\n{error}", file=sys.stderr, flush=True)
        problem.state.x.array[:], problem.inflow, problem.forms.mixing.value = kept
        return estimate
    settings, norm = problem.settings, problem.residual_norm()
    solved.outcome = problem.outcome(
        norm, settings.residual_absolute, settings.residual_relative, problem.solver.factorizations
    )
    solved.read()
    if solved.unsteady is None:
        return error_estimate.of(solved, document, tree, lambda sampler: at_probes(sampler)[0], before)
    return error_estimate.of_mean(estimate, kept[2], solved.unsteady.difference)


def _record(path, solved, value, estimate, cpu_seconds):
    error = f", error {estimate['ffr']:.4f}" if estimate else ""
    print(f"{path}: FFR {value:.4f}{error}", file=sys.stderr, flush=True)
    return {
        "mesh": pathlib.Path(path).name,
        "status": status(solved),
        "dofs": solved.space.dofs,
        "ffr": value,
        "error_estimate": estimate["ffr"] if estimate else None,
        "factorizations": solved.problem.solver.factorizations,
        "cpu_seconds": cpu_seconds,
    }


def status(solved):
    """`converged`, or `unsteady` where the flow is a mean over time."""
    return "unsteady" if solved.unsteady else "converged"


def collect(solved, probes, tree, network, reference):
    """(document of ffr.json without timings, pullback table)."""
    names = solved.boundaries.names
    flow_of = dict(zip(names, solved.outflows))
    by_index = np.array([flow_of[name] for name in network.names])
    pressure = solved.boundaries.pressures(solved.outflows)
    inflow, outcome = solved.problem.inflow, solved.outcome

    def flow_at(branch, s_mm):
        return float(by_index[network.downstream(branch, s_mm)].sum())

    table = ffr.pullback(tree, solved.sampler, reference, flow_at)
    if solved.unsteady:
        for probe, amplitude in zip(probes, solved.unsteady.amplitudes):
            probe["ffr_amplitude"] = float(amplitude)
    answer = {
        "schema": "vci-ffr-1",
        "status": status(solved),
        "model": "3D Navier-Stokes, Taylor-Hood P2-P1 on quadratic tetrahedra",
        "ffr": probes[0]["ffr"],
        "probes": probes,
        "outlets": [
            {"name": name, "flow_m3_per_s": float(q), "pressure_pa": float(p), "ffr": float(p / reference)}
            for name, q, p in zip(names, solved.outflows, pressure)
        ],
        "inlet_flow_m3_per_s": inflow,
        "mass_imbalance": float(abs(solved.outflows.sum() - inflow) / inflow),
        "energy": energy.balance(solved.problem),
        "unsteady": solved.unsteady.document() if solved.unsteady else None,
        "iterations": outcome.iterations,
        "residual_absolute": outcome.residual_absolute,
        "residual_relative": outcome.residual_relative,
        "jet_mixing": solved.problem.mixing,
        "dofs": solved.space.dofs,
        "cells": len(solved.space.nodes()[1]),
    }
    return answer, table


def fields(solved, document, reference):
    """Arguments of output.write_vtu."""
    points, cells = solved.space.nodes()
    velocity, pressure = solved.sampler.velocity, solved.sampler.pressure
    wall = np.zeros(len(points), bool)
    wall[solved.space.wall_nodes()] = True
    stress = wall_shear.wall_shear_stress(points, cells, velocity, wall, viscosity.of(document))
    return (
        points,
        cells,
        {
            "velocity_m_per_s": velocity,
            "pressure_pa": pressure,
            "ffr": pressure / reference,
            "wall_shear_stress_pa": stress,
        },
    )
