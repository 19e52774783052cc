"""Compares one slice of a patient with CalculiX through a whole procedure, from predilatation to recoil.

The slice does the steps of the study's procedure with their devices. CalculiX has the same mesh, tissues and support,
but no devices. After each load step it moves the lumen's nodes to the positions found by the slice. After each
inflation and deflation two pressures are compared: that of the tissue on the lumen by CalculiX, and that of the devices
by the slice. The stiffness of tissue and devices turns their difference into a difference of area. In both codes an
element has one tissue, taken at its middle.

Devices as bodies in contact were tried: CalculiX 2.20 did not converge while the balloon opened.
"""

import pathlib
import tempfile

import numpy as np

from common.documents import config
from common.errors import InputError
from common.files import write_json

from .. import run
from ..slices.model import SliceModel
from ..solid import laws, tissue
from ..treatment import procedure
from ..tube.procedure import enclosed_area
from . import calculix

SETTING_KEYS = ("wall_c10_mpa", "wall_c20_mpa", "bulk_modulus_mpa", "support_mpa_per_mm")
SIDE_POINTS, SIDE_WEIGHTS = np.polynomial.legendre.leggauss(3)


class RecordedSlice(SliceModel):
    """A slice that records each load step's name, lumen nodes (mm), loads and mean device pressure (MPa)."""

    def place(self, inner_mm, outer_mm, material):
        """Starts a new slice as SliceModel does, and clears the record."""
        super().place(inner_mm, outer_mm, material)
        self.records = []

    def advance(self, target, name="load"):
        """Moves the loads as SliceModel does, and records the state reached."""
        super().advance(target, name)
        at, loads = self.lumen_position(), self.loads()
        self.records.append({"name": name, "lumen": at, "pressure": mean_pressure(at, loads), "loads": loads})


def mean_pressure(lumen, loads):
    """Mean pressure in MPa on a lumen of area A: the integral of p n . x along its edge, over 2 A.

    lumen (2 around, 2): nodes of quadratic sides, in mm. loads: loads of a SliceModel, which give the pressure p at a
    place x with the normal n. Under a uniform pressure the result is this pressure.
    """
    first, middle, last = lumen[0::2], lumen[1::2], np.roll(lumen[0::2], -1, axis=0)
    total, area = 0.0, 0.0
    for x, weight in zip(SIDE_POINTS, SIDE_WEIGHTS):
        at = 0.5 * x * (x - 1) * first + (1 - x * x) * middle + 0.5 * x * (x + 1) * last
        along = (x - 0.5) * first - 2 * x * middle + (x + 0.5) * last
        swept = weight * (at[:, 0] * along[:, 1] - at[:, 1] * along[:, 0])
        distance, pressure = np.linalg.norm(at, axis=1), loads["pressure"]
        for device in ("balloon", "stent"):
            law = [loads[f"{device}_{name}"] for name in ("radius", "stiffness", "cap")]
            pressure = pressure + loads[f"{device}_share"] * laws.device_pressure(distance, *law, sqrt=np.sqrt)
        total, area = total + np.sum(pressure * swept), area + np.sum(swept)
    return float(total / area)


class Section:
    """The section of a patient at arc length s_mm that both codes solve. Each element has one tissue.

    `around` elements round the lumen have 2 `around` rays of nodes. theta, inner, outer (2 around,): angle in rad of
    each ray, radii in mm of the lumen and of the outer edge there. tissues (around, through, 4): for each element 1 in
    plaque or 0 in the wall, and the plaque's shear modulus, yield stress and hardening in MPa.
    """

    def __init__(self, patient, s_mm, settings):
        around, self.through = settings["elements_around"], settings["elements_through"]
        self.theta = np.pi * np.arange(2 * around) / around
        self.inner, self.outer = tissue.inner_outer_radii(patient.branch, patient.wall_mm, s_mm, self.theta)
        depth = (np.arange(self.through) + 0.5) / self.through
        radius = self.inner[1::2, None] + (self.outer - self.inner)[1::2, None] * depth
        angle = np.broadcast_to(self.theta[1::2, None], radius.shape)
        values = tissue.material_constants(patient.branch, np.full(radius.size, s_mm), angle.ravel(), radius.ravel())
        self.tissues = np.stack(values, axis=1).reshape(around, self.through, 4)
        self.tissues[..., 0] = self.tissues[..., 0] > 0.5

    def material(self, angle, radius):
        """Tissue of the element at points (n,) in rad and mm, in the form that SliceModel.place takes."""
        turn = np.mod(angle, 2 * np.pi) * len(self.theta) / (4 * np.pi)
        column = np.minimum(turn.astype(int), len(self.theta) // 2 - 1)
        x = 2 * (turn - column) - 1
        edges = []
        for ray in (self.inner, self.outer):
            first, middle, last = ray[2 * column], ray[2 * column + 1], ray[(2 * column + 2) % len(ray)]
            edges.append(0.5 * x * (x - 1) * first + (1 - x * x) * middle + 0.5 * x * (x + 1) * last)
        depth = (radius - edges[0]) / (edges[1] - edges[0]) * self.through
        return tuple(self.tissues[column, np.clip(depth.astype(int), 0, self.through - 1)].T)

    def input_deck(self, settings, lumens):
        """Text of CalculiX's input: a step for each of the lumens (steps, 2 around, 2), positions in mm."""
        layer = calculix.build_layer(self.theta, self.inner, self.outer, self.through)
        each = self.tissues[layer.ring_index, layer.depth_index].copy()
        each[each[:, 0] == 0, 1:] = 0
        kinds, of_element = np.unique(each.round(9), axis=0, return_inverse=True)
        sets = {f"TISSUE{k}": of_element == k for k in range(len(kinds))}
        out = calculix.mesh_lines(layer, sets)
        bulk = settings["bulk_modulus_mpa"]
        for name, (plaque, *constants) in zip(sets, kinds):
            wall = calculix.wall_lines(name, settings["wall_c10_mpa"], settings["wall_c20_mpa"], bulk)
            out += calculix.plaque_lines(name, *constants, bulk) if plaque else wall
        out += [f"*SOLID SECTION, ELSET={name}, MATERIAL={name}" for name in sets]
        out += calculix.support_lines(layer, settings["support_mpa_per_mm"])
        for moved in lumens - self.lumen():
            out += ["*STEP, NLGEOM, INC=1000", "*STATIC", "0.5, 1., 1e-6, 1.", *layer.displacement_lines(moved)]
            out += ["*NODE PRINT, NSET=WHOLELUMEN, FREQUENCY=1000", "RF", "*END STEP"]
        return "\n".join(out) + "\n"

    def lumen(self):
        """Positions (2 around, 2) in mm of the lumen's nodes at rest."""
        return self.inner[:, None] * np.stack([np.cos(self.theta), np.sin(self.theta)], axis=1)


def procedure_stages(recorded, steps):
    """[(step name, "inflated" or "deflated", index of load step)] of the procedure's steps.

    Inflated is the load step with the widest lumen, deflated the last one.
    """
    found = []
    for step in steps:
        indices = [k for k, entry in enumerate(recorded) if entry["name"].endswith(f"step {step.name}")]
        if indices:
            widest = max(indices, key=lambda k: lumen_areas(recorded[k]["lumen"][None])[0])
            found += [(step.name, "inflated", widest), (step.name, "deflated", indices[-1])]
    return found


def lumen_areas(lumens):
    """Areas (n,) in mm2 of lumens (n, 2 around, 2)."""
    return enclosed_area(lumens[:, :, 0], lumens[:, :, 1])


def comparison_rows(recorded, forces, steps):
    """A row (dict) for each stage: the lumen's area in mm2, the same in both codes, and both mean pressures in MPa.

    Its worth_in_area_percent is the change of area that the difference of the pressures would make. recorded, forces:
    results of solve_by_slice and solve_by_calculix.
    """
    rows = []
    for name, stage, index in procedure_stages(recorded, steps):
        entry, area = recorded[index], float(lumen_areas(recorded[index]["lumen"][None])[0])
        position, force = forces[index]
        calculix_pressure = float(np.sum(position * force) / (2 * area * calculix.LAYER_HEIGHT_MM))
        radius = np.sqrt(area / np.pi)
        stiffness = max(_tissue_stiffness(recorded, index), 0.0) + _device_stiffness(entry["loads"])
        rows.append(
            {
                "step": name,
                "stage": stage,
                "area_mm2": area,
                "slice_pressure_mpa": entry["pressure"],
                "calculix_pressure_mpa": calculix_pressure,
                "pressure_difference_mpa": entry["pressure"] - calculix_pressure,
                "worth_in_area_percent": float(200 * abs(entry["pressure"] - calculix_pressure) / (stiffness * radius)),
            }
        )
    return rows


def _device_stiffness(loads):
    """Stiffness in MPa/mm of the devices that hold the lumen."""
    return sum(loads[f"{d}_share"] * loads[f"{d}_stiffness"] for d in ("balloon", "stent") if loads[f"{d}_radius"])


def _tissue_stiffness(recorded, index):
    """Change of the mean pressure over change of the lumen's radius (MPa/mm) in load step `index`."""
    radius = np.sqrt(lumen_areas(np.stack([entry["lumen"] for entry in recorded[index - 1 : index + 1]])) / np.pi)
    change = recorded[index]["pressure"] - recorded[index - 1]["pressure"]
    return change / (radius[1] - radius[0]) if abs(radius[1] - radius[0]) > 1e-6 else 0.0


def compare(scene_path, truth_path, out, program="ccx", s_mm=None, settings_path=None):
    """Writes `out`/case_vs_calculix.json.

    s_mm: arc length of the slice; None: where the vessel under the first stent is tightest. Raises InputError,
    ComputationError.
    """
    scene, settings = run.load_scene(scene_path), config.load_section(settings_path, "reference")
    patient, steps = run.read_patient_and_steps(scene, scene_path, truth_path)
    stents = [step.stent for step in steps if step.stent]
    if not stents:
        raise InputError("no stent in the scene", f"{scene_path}: procedure", "none", "a plan with a stent")
    if s_mm is None:
        places = np.linspace(*stents[0].ends(), 200)
        s_mm = float(places[np.argmin(patient.branch.radius(places))])
    section = Section(patient, s_mm, settings)
    recorded = solve_by_slice(section, steps, s_mm, settings)
    forces = solve_by_calculix(section, recorded, settings, program)
    rows = comparison_rows(recorded, forces, steps)
    document = {"schema": "vci-case-vs-calculix-1", "case": scene.get("case"), "s_mm": s_mm, "stages": rows}
    write_json(pathlib.Path(out) / "case_vs_calculix.json", document)
    for row in rows:
        print(", ".join(f"{key} {value:.5g}" if isinstance(value, float) else str(value) for key, value in row.items()))
    return document


def solve_by_slice(section, steps, s_mm, settings):
    """The records of a RecordedSlice that goes through the steps of the procedure."""
    model = RecordedSlice(settings["elements_around"], section.through, *(settings[key] for key in SETTING_KEYS))
    model.place(section.inner, section.outer, section.material)
    procedure.run_procedure(model, steps, s_mm, settings, True, "section")
    return model.records


def solve_by_calculix(section, recorded, settings, program):
    """[(positions (n, 2) mm, forces (n, 2) N)] of the lumen's nodes at all heights, after each load step."""
    lumens = np.array([entry["lumen"] for entry in recorded])
    with tempfile.TemporaryDirectory() as folder:
        text = section.input_deck(settings, lumens)
        layer = calculix.build_layer(section.theta, section.inner, section.outer, section.through)
        forces = calculix.run_and_read(
            program, text, folder, "forces", len(lumens), len(layer.lumen_nodes_all_heights()[0])
        )
    return [(lumen[layer.lumen_nodes_all_heights()[1]], force) for lumen, force in zip(lumens, forces)]
