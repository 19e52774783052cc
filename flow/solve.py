"""A solve from files to files: reduced model, coarse mesh, fine mesh, FFR with its error estimate."""

import pathlib
import resource
import sys
import time

import numpy as np

from common.errors import ComputationError
from flow import energy, error_estimate, ffr, jet, locate, nonlinear, outlets, output, spaces, viscosity, wall_shear


class Solved:
    """One mesh with its solution."""

    def __init__(self, space, boundaries, problem, outcome):
        self.space, self.boundaries, self.problem, self.outcome = space, boundaries, problem, outcome
        self.sampler = locate.FieldSampler(space, problem.state.x.array)
        self.outflows = boundaries.outflows(problem.state_vector())

    def destroy(self):
        self.problem.destroy()
        self.boundaries.destroy()


def solve_mesh(path, document, settings, tree, network, flows, start=None):
    """Solved from a mesh file; `start` (Solved on another mesh) gives the guess, else the path from rest does."""
    space = spaces.read(path)
    boundaries = outlets.Boundaries(space, document)
    jet_length = jet.mixing_length(space, tree, settings.jet_spread)
    problem = nonlinear.FlowProblem(space, boundaries, document, settings, jet_length)
    print(f"{path}: {space.dofs} dofs", file=sys.stderr, flush=True)
    order = [network.names.index(name) for name in boundaries.names]

    def resistances_at(fraction):
        return network.resistances_at(flows, fraction)[order]

    if start is None:
        outcome = problem.solve(resistances_at)
    else:
        outcome = problem.solve_from_guess(start.problem)
    return Solved(space, boundaries, problem, outcome)


def run(mesh, coarse, document, tree, network, settings, folder):
    """Solves and writes solution.vtu, pullback.csv and ffr.json to `folder`; returns the document of ffr.json."""
    begin, begin_cpu = time.perf_counter(), time.process_time()
    flows = network.solve()
    simple = reduced_answer(network, flows, tree, document)
    print(f"reduced model: FFR {simple['ffr']:.4f}", file=sys.stderr, flush=True)
    first = coarse_solution(coarse, document, settings, tree, network, flows) if coarse else None
    solved = solve_mesh(mesh, document, settings, tree, network, flows, first)
    reference = ffr.reference_pa(document, tree, solved.sampler)
    probes = ffr.at_probes(document["probes"], tree, solved.sampler, reference)

    def distal(sampler):
        return ffr.at_probes(document["probes"][:1], tree, sampler, ffr.reference_pa(document, tree, sampler))[0]["ffr"]

    estimate = error_estimate.of(solved, first, probes[0]["ffr"], distal)
    if first:
        first.destroy()
    answer, table = collect(solved, probes, tree, network, reference)
    answer["reduced_model"] = simple
    answer["error_estimate"] = estimate
    answer["seconds"] = time.perf_counter() - begin
    answer["cpu_seconds"] = time.process_time() - begin_cpu
    answer["peak_memory_mib"] = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024
    output.write_all(pathlib.Path(folder), fields(solved, document, reference), table, answer)
    solved.destroy()
    return answer


def coarse_solution(path, document, settings, tree, network, flows):
    """Solved on the coarse mesh, or None where the jet is too thin for it: the fine mesh then starts from rest."""
    try:
        return solve_mesh(path, document, settings, tree, network, flows)
    except ComputationError as error:
        print(f"coarse mesh gives no starting guess, no error estimate:\n{error}", file=sys.stderr, flush=True)
        return None


def reduced_answer(network, flows, tree, document):
    """FFR at the probe `distal` and outlet flows of the reduced model."""
    pressures = network.pressures(flows, network.inlet_pa)
    probe = document["probes"][0]
    s_mm, _ = tree[probe["branch"]].project(np.array(probe["point_mm"]))
    s, p = pressures[probe["branch"]]
    return {
        "model": "1D network",
        "ffr": float(np.interp(s_mm * 1e-3, s, p) / network.inlet_pa),
        "outlet_flows_m3_per_s": flows.tolist(),
    }


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
    answer = {
        "schema": "vci-ffr-1",
        "status": "converged",
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
