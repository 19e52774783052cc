"""A solve from files to files: reduced models, the 3D flow to its tolerance (flow.adaptive), FFR and its error."""

import pathlib
import resource
import sys
import time

import numpy as np

from common.errors import ComputationError
from flow import adaptive, output
from flow.errors import error_estimate, pointwise
from flow.physics import energy, ffr
from flow.discretisation import spaces
from flow.physics import viscosity, wall_shear
from flow.reduced import answer as reduced_answer, flow_range
from flow.solvers import solved_mesh

LARGE = 0.05  # larger differences of the models' FFR get a warning
# Largest difference of out- and inflow, over the inflow, that is trusted. Solves by factorization have 1e-14 to 1e-13.
LARGEST_IMBALANCE = 1e-8


def run(paths, case, folder, start=None, made_from=None):
    """Solves and writes solution.vtu, pullback.csv and ffr.json to `folder`; returns the document of ffr.json.

    paths: of the meshes, the coarsest first; case: reduced.extended.Extended; start: inputs.solution.Start.
    made_from: SHA-256 of files that the answer rests on, for the document.
    """
    begin, begin_cpu = time.perf_counter(), _cpu_seconds()
    spaces.check_coarser(paths)
    document, settings, tree = case.document, case.settings, case.original
    predicted = case.predictor()
    models = predicted.answers()
    extensions = case.report(models)
    print(f"1D network: FFR {models['network']['ffr']:.4f}", file=sys.stderr, flush=True)
    if settings.model == "3d":
        search = adaptive.Search(document, settings, tree, predicted)
        solved = search.run(paths, start)
    else:
        solved = reduced_answer.Reduced(settings.model, predicted, paths[0])
    reference, estimate = ffr.reference_pa(document, tree, solved.sampler), solved.estimate
    answer, table = collect(solved, case, reference)
    answer |= _of_flow(solved) if settings.model == "3d" else {"dofs": solved.dofs}
    answer["error_estimate"] = error_estimate.document(estimate)
    pointwise.write(solved, case, answer, table)
    if settings.model == "3d":
        models["3d"] = {"ffr": answer["ffr"], "error_estimate": estimate["ffr"] if estimate else None}
        answer["ffr_tolerance"] = settings.ffr_tolerance
        answer["tolerance_met"] = adaptive.within(estimate, settings)
        answer["mesh"], answer["meshes"] = pathlib.Path(solved.path).name, search.meshes
        answer["start"] = search.started
        warnings = adaptive.missed(estimate, settings, [probe["name"] for probe in answer["probes"]])
    else:
        warnings = reduced_answer.unknown_error(settings.model)
    answer["made_from"], answer["models"] = made_from, models
    branch, s_mm, _ = tree.place_of(document["probes"][0])
    answer["ffr_range"] = flow_range.of_answer(answer["ffr"], document, case.network_at, (branch.name, s_mm))
    answer["warnings"] = case.warnings + document.get("warnings", []) + compared(models)
    answer["warnings"] += ffr.rising(answer["probes"], table)
    answer["warnings"] += ffr.displaced(answer["probes"], tree, table) + warnings
    answer["extensions"] = extensions
    answer["reduced_model"] = {"model": "1D network", **models["network"]}
    answer["seconds"] = time.perf_counter() - begin
    answer["cpu_seconds"] = _cpu_seconds() - begin_cpu
    answer["peak_memory_mib"] = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024
    output.write_all(pathlib.Path(folder), fields(solved, document, reference), table, answer)
    solved.destroy()
    predicted.destroy()
    return answer


def _cpu_seconds():
    """CPU seconds of this process and of the programs that it ran (gmsh)."""
    spent = [resource.getrusage(whose) for whose in (resource.RUSAGE_SELF, resource.RUSAGE_CHILDREN)]
    return sum(one.ru_utime + one.ru_stime for one in spent)


def in_words(answer):
    """The answer in one line, with its error and, where the flow is not simply a steady one, its status."""
    estimate = answer["error_estimate"]
    error = f"{estimate['ffr']:.4f}" if estimate else "unknown"
    status = "" if answer["status"] == solved_mesh.CONVERGED else f" ({answer['status']})"
    return f"FFR {answer['ffr']:.4f} +- {error}{status}"


def compared(models):
    """Warnings, printed too, where the models' FFR differ by more than LARGE."""
    found = {name: entry["ffr"] for name, entry in models.items() if entry["ffr"] is not None}
    if max(found.values()) - min(found.values()) <= LARGE:
        return []
    values = ", ".join(f"{name} {value:.3f}" for name, value in found.items())
    said = f"the models' FFR differ by more than {LARGE:g}: {values}; look at the mesh and sections.csv"
    print(said, file=sys.stderr, flush=True)
    return [said]


def collect(solved, case, reference):
    """(the part of ffr.json's document that all models have, table of pullback.csv without errors).

    solved: solvers.solved_mesh.Solved or reduced.answer.Reduced; case: reduced.extended.Extended; reference: pressure
    in Pa that FFR is over.
    """
    tree, network, names, estimate = case.original, case.network, solved.names, solved.estimate
    flow_of = dict(zip(names, solved.outflows))
    by_index = np.array([flow_of[name] for name in network.names])

    def flow_at(branch, s_mm):
        return float(by_index[network.downstream(branch, s_mm)].sum())

    probes = ffr.at_probes(case.document, tree, solved.sampler)
    for k, probe in enumerate(probes):
        probe["error_estimate"] = estimate["probes"][k] if estimate else None
    at_ends = ffr.at_ends(names, solved.pressures, case, solved.sampler, reference)
    answer = {
        "schema": "vci-ffr-1",
        "status": solved.status,
        "model": solved.model,
        "ffr": probes[0]["ffr"],
        "probes": probes,
        "outlets": [
            {"name": name, "flow_m3_per_s": float(q), "pressure_pa": float(p), "ffr": value}
            for name, q, p, value in zip(names, solved.outflows, solved.pressures, at_ends)
        ],
        "inlet_flow_m3_per_s": solved.inflow,
    }
    return answer, ffr.pullback(tree, solved.sampler, reference, flow_at)


def _of_flow(solved):
    """The part of ffr.json's document that only a flow in three dimensions has. Raises ComputationError."""
    outcome = solved.outcome
    return {
        "mass_imbalance": _conserved(solved.outflows.sum(), solved.inflow),
        "energy": energy.balance(solved.problem),
        "iterations": outcome.iterations,
        "residual_absolute": outcome.residual_absolute,
        "residual_relative": outcome.residual_relative,
        "artificial_viscosity": solved.artificial,
        "dofs": solved.space.dofs,
        "cells": len(solved.space.nodes()[1]),
    }


def _conserved(outflow, inflow):
    """|outflow - inflow| / inflow. Raises ComputationError above LARGEST_IMBALANCE."""
    imbalance = float(abs(outflow - inflow) / abs(inflow))
    if not imbalance <= LARGEST_IMBALANCE:
        raise ComputationError(
            "mass is not conserved",
            "flow through the outlets against the inlet's",
            f"they differ by {imbalance:.3e} of the flow",
            f"at most {LARGEST_IMBALANCE:g} is trusted: look at the mesh, lower residual_relative",
        )
    return imbalance


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
