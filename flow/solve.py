"""`flow solve`: the reduced models, the 3D flow to its tolerance (flow.adaptive), FFR with its error, output files."""

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

LARGE_DIFFERENCE = 0.05  # a larger difference between the FFR of 3D and reduced models gets a warning
# Largest |outflow - inflow| over the inflow; a flow with more is refused. Solves by factorization have 1e-14 to 1e-13.
LARGEST_IMBALANCE = 1e-8


def run(paths, case, folder, start=None, made_from=None):
    """Solves, writes solution.vtu, pullback.csv and ffr.json to `folder`, and returns the document of ffr.json.

    paths: mesh files, the coarsest first; case: reduced.extended.ExtendedLumen; start: inputs.solution.StartState, the
    flow of another state, or None; made_from: {key: SHA-256} of input files, to be noted in ffr.json. Raises
    ComputationError.
    """
    begin, begin_cpu = time.perf_counter(), _cpu_seconds()
    spaces.check_coarser(paths)
    document, settings, tree = case.document, case.settings, case.original_tree
    predictor = case.predictor()
    models = predictor.answers()
    print(f"1D network: FFR {models['network']['ffr']:.4f}", file=sys.stderr, flush=True)
    if settings.model == "3d":
        search = adaptive.MeshSearch(document, settings, tree, predictor)
        solved = search.run(paths, start)
    else:
        solved = reduced_answer.ReducedAnswer(settings.model, predictor, paths[0])
    estimate = solved.estimate
    answer, table = shared_entries(solved, case)
    answer |= _flow_entries(solved) if settings.model == "3d" else {"dofs": solved.dofs}
    answer["error_estimate"] = error_estimate.shown_entries(estimate)
    pointwise.add_estimates(solved, case, answer, table)
    if settings.model == "3d":
        models["3d"] = {"ffr": answer["ffr"], "error_estimate": estimate["ffr"] if estimate else None}
        answer["ffr_tolerance"] = settings.ffr_tolerance
        answer["tolerance_met"] = adaptive.tolerance_met(estimate, settings)
        answer["mesh"], answer["meshes"] = pathlib.Path(solved.path).name, search.meshes
        answer["start"] = search.start_record
        warnings = adaptive.tolerance_warnings(estimate, settings, [probe["name"] for probe in answer["probes"]])
    else:
        warnings = reduced_answer.unknown_error_warning(settings.model)
    answer["made_from"], answer["models"] = made_from, models
    branch, s_mm, _ = tree.project_probe(document["probes"][0])
    answer["ffr_range"] = flow_range.ffr_range(answer["ffr"], document, case.network_at, (branch.name, s_mm))
    answer["warnings"] = case.warnings + document.get("warnings", []) + model_difference_warnings(models)
    answer["warnings"] += ffr.slope_warnings(answer["probes"], table)
    answer["warnings"] += ffr.displacement_warnings(answer["probes"], tree, table) + warnings
    output.print_warnings(answer["warnings"])
    answer["extensions"] = {"ends": case.extended_ends()}
    answer["reduced_model"] = {"model": "1D network", **models["network"]}
    answer["seconds"] = time.perf_counter() - begin
    answer["cpu_seconds"] = _cpu_seconds() - begin_cpu
    answer["peak_memory_mib"] = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024
    output.write_all(pathlib.Path(folder), vtu_fields(solved, document), table, answer)
    solved.destroy()
    predictor.destroy()
    return answer


def _cpu_seconds():
    """CPU seconds of this process and of the programs that it ran."""
    usage = [resource.getrusage(whose) for whose in (resource.RUSAGE_SELF, resource.RUSAGE_CHILDREN)]
    return sum(one.ru_utime + one.ru_stime for one in usage)


def summary_line(answer):
    """One line for the user: FFR and its error, and the status if an artificial viscosity is left.

    answer: document of ffr.json.
    """
    estimate = answer["error_estimate"]
    error = f"{estimate['ffr']:.4f}" if estimate else "unknown"
    status = "" if answer["status"] == solved_mesh.CONVERGED else f" ({answer['status']})"
    return f"FFR {answer['ffr']:.4f} +- {error}{status}"


def model_difference_warnings(models):
    """[warning] if the FFRs of the models differ by more than LARGE_DIFFERENCE. models: entry `models` of ffr.json."""
    found = {name: entry["ffr"] for name, entry in models.items() if entry["ffr"] is not None}
    if max(found.values()) - min(found.values()) <= LARGE_DIFFERENCE:
        return []
    values = ", ".join(f"{name} {value:.3f}" for name, value in found.items())
    return [f"the models' FFR differ by more than {LARGE_DIFFERENCE:g}: {values}; look at the mesh and sections.csv"]


def shared_entries(solved, case):
    """(the entries of ffr.json that 3D and reduced models both have, table of pullback.csv without estimated errors).

    solved: solvers.solved_mesh.SolvedMesh or reduced.answer.ReducedAnswer; case: reduced.extended.ExtendedLumen.
    """
    tree, network, names, estimate = case.original_tree, case.network, solved.outlet_names, solved.estimate
    flow_of = dict(zip(names, solved.outflows))
    by_index = np.array([flow_of[name] for name in network.outlet_names])

    def flow_at(branch, s_mm):
        return float(by_index[network.downstream(branch, s_mm)].sum())

    probes = ffr.at_probes(case.document, tree, solved.sampler)
    for k, probe in enumerate(probes):
        probe["error_estimate"] = estimate["probes"][k] if estimate else None
    at_ends = ffr.at_outlets(names, solved.pressures, case, solved.sampler)
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
    return answer, ffr.pullback(tree, solved.sampler, case.document["map_pa"], flow_at)


def _flow_entries(solved):
    """The entries of ffr.json that only a 3D flow has. Raises ComputationError if mass is not conserved."""
    outcome = solved.outcome
    return {
        "mass_imbalance": _mass_imbalance(solved.outflows.sum(), solved.inflow),
        "energy": energy.balance(solved.problem),
        "iterations": solved.iterations,
        "residual_absolute": outcome.residual_absolute,
        "residual_relative": outcome.residual_relative,
        "artificial_viscosity": solved.artificial_viscosity,
        "dofs": solved.space.dofs,
        "cells": len(solved.space.nodes()[1]),
    }


def _mass_imbalance(outflow, inflow):
    """|outflow - inflow| / inflow. Raises ComputationError above LARGEST_IMBALANCE."""
    imbalance = float(abs(outflow - inflow) / abs(inflow))
    if not imbalance <= LARGEST_IMBALANCE:
        raise ComputationError(
            "mass is not conserved",
            "flow through the outlets against the inlet's",
            f"they differ by {imbalance:.3e} of the flow",
            f"at most {LARGEST_IMBALANCE:g} is trusted: look at the mesh",
        )
    return imbalance


def vtu_fields(solved, document):
    """(points, cells, {name: values}) for output.write_vtu; document: content of boundary.json."""
    points, cells = solved.space.nodes()
    velocity, pressure = solved.sampler.velocity, solved.sampler.pressure
    wall = np.zeros(len(points), bool)
    wall[solved.space.wall_nodes()] = True
    stress = wall_shear.wall_shear_stress(points, cells, velocity, wall, viscosity.from_document(document))
    return (
        points,
        cells,
        {
            "velocity_m_per_s": velocity,
            "pressure_pa": pressure,
            "ffr": pressure / document["map_pa"],
            "wall_shear_stress_pa": stress,
        },
    )
