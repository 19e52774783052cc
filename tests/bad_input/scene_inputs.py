"""Scenes of the deployment engine, and the files that they name."""

import json

from common import vtp
from input_cases import BUILD, input_case
from vci.benchmarks import scenes

TUBE = scenes.Tube(length=16, edge=1.2, lesion_length=6)


def scene(folder, change=None, command="deploy", text=None, out="out"):
    """`vci deploy`, or another command, of a small scene. change(document) alters its document, text(file) its file."""
    path = scenes.write_scene(folder / "case", TUBE, length=6.0, numerics={"device_edge_mm": 1.2})
    document = json.loads(path.read_text())
    if change:
        change(document)
    path.write_text(json.dumps(document) if text is None else text(path.read_text()))
    return [BUILD / "vci", command, path, "--out", folder / out]


def setting(*keys, value):
    """A change(document) that sets the value at these keys."""

    def change(document):
        node = document
        for key in keys[:-1]:
            node = node[key]
        node[keys[-1]] = value

    return change


FIRST = ("procedure", 0, "devices", 0)
CHANGES = {
    "a scene of another schema": setting("schema", value="vci-scene-99"),
    "a scene with a misspelt key": setting("procedur", value=[]),
    "a step of no known action": setting("procedure", 0, "action", value="laser"),
    "a procedure of no steps": setting("procedure", value=[]),
    "a device that the scene does not define": setting(*FIRST, "device", value="none"),
    "a branch that the centreline does not have": setting(*FIRST, "branch", value="side7"),
    "a device past the end of its branch": setting(*FIRST, "centre_s_mm", value=99),
    "a pressure below zero": setting(*FIRST, "pressure_bar", value=-3),
    "a pressure in kilopascals": setting(*FIRST, "pressure_bar", value=1000),
    "a pressure in words": setting(*FIRST, "pressure_bar", value="high"),
    "a step named as a path": setting("procedure", 0, "name", value="../../escape"),
    "a stent of no links and a million crowns": setting("devices", "stent", "crowns", value=1000000),
    "elements of a picometre": setting("numerics", "device_edge_mm", value=1e-9),
    "a lumen that is not there": setting("lumen", value="gone.vtp"),
    "a lumen that is the scene itself": setting("lumen", value="scene.json"),
    "a coarse lumen that is not there": setting("coarse_lumen", value="gone.vtp"),
    "a lumen in place of the centreline": setting("centreline", value="lumen.vtp"),
    "a folder in place of the lumen": setting("lumen", value="."),
    "a lumen that is a device without end": setting("lumen", value="/dev/zero"),
    "a segment from high to low": setting("segment", value={"branch": "main", "s_start_mm": 12, "s_end_mm": 4}),
    "a wall of no known model": setting("wall", "model", value="steel"),
    "a mean pressure of less than nothing": setting("patient", "map_pa", value=-12000),
}


def make(name, change):
    input_case(name)(lambda folder: scene(folder, change))


for one, its_change in CHANGES.items():
    make(one, its_change)


@input_case("the lumen of another vessel as the coarse lumen")
def other_vessel(folder):
    """A vessel that bends away from the scene's straight one."""
    scenes.write_geometry(folder / "other", scenes.Tube(length=16, edge=1.2, lesion_length=6, curvature=0.1))
    return scene(folder, setting("coarse_lumen", value="../other/lumen.vtp"))


@input_case("a scene that is not there")
def _(folder):
    return [BUILD / "vci", "deploy", folder / "scene.json", "--out", folder / "out"]


@input_case("a scene that was cut off")
def _(folder):
    return scene(folder, text=lambda whole: whole[:200])


@input_case("a scene with NaN")
def _(folder):
    return scene(folder, text=lambda whole: whole.replace('"pressure_bar": 10', '"pressure_bar": NaN', 1))


@input_case("a scene with a key given twice")
def _(folder):
    return scene(folder, text=lambda whole: whole.replace('"schema"', '"schema": "vci-scene-1", "schema"', 1))


@input_case("a scene a hundred thousand lists deep")
def _(folder):
    return scene(folder, text=lambda whole: 100000 * "[" + 100000 * "]")


@input_case("results in the place of the scene's own lumen")
def _(folder):
    return scene(folder, out="case")


@input_case("results below a file")
def _(folder):
    (folder / "mine").write_text("mine")
    return scene(folder, out="mine/out")


@input_case("a lumen whose radii are missing")
def _(folder):
    command = scene(folder)
    lumen = vtp.read(folder / "case" / "lumen.vtp", "")
    lumen.GetPointData().RemoveArray("radius_mm")
    vtp.write(folder / "case" / "lumen.vtp", lumen)
    return command


@input_case("a lumen without its regions")
def _(folder):
    command = scene(folder)
    points, triangles = vtp.points_and_triangles(vtp.read(folder / "case" / "lumen.vtp", ""))
    vtp.write(folder / "case" / "lumen.vtp", vtp.surface(points, triangles))
    return command


@input_case("a lumen of another vessel than the centreline's")
def _(folder):
    command = scene(folder)
    lumen = vtp.read(folder / "case" / "lumen.vtp", "")
    points = vtp.points(lumen)
    for k, place in enumerate(points + [40, 0, 0]):
        lumen.GetPoints().SetPoint(k, *place)
    vtp.write(folder / "case" / "lumen.vtp", lumen)
    return command


@input_case("a step with a name of blanks and an umlaut")
def _(folder):
    return scene(folder, setting("procedure", 0, "name", value="Vordehnung für 1 und 2"))


# Inputs that are unusual, but valid scenes.


@input_case("a scene in a folder with blanks, quotes and an umlaut")
def _(folder):
    (folder / "Fall 'ä' $1").mkdir()
    return scene(folder / "Fall 'ä' $1", command="radius-correct")


@input_case("a scene of one balloon alone")
def _(folder):
    return scene(folder, lambda document: document.update(procedure=document["procedure"][:1]), "radius-correct")


@input_case("a scene whose lumen is an absolute path")
def _(folder):
    return scene(folder, setting("lumen", value=str((folder / "case" / "lumen.vtp").resolve())), "radius-correct")


@input_case("a scene with a byte-order mark and Windows line ends")
def _(folder):
    return scene(folder, command="radius-correct", text=lambda whole: "\ufeff" + whole.replace("\n", "\r\n"))
