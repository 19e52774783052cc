"""The 3D viewer: values on the wall, their packing and unpacking, and the keyboard."""

import json
import pathlib
import re
import shutil
import subprocess

import numpy as np
import pytest

from common import vtp
from reports.figures.style import LABELS
from reports.inputs.case_files import CaseFiles
from reports.measuring.metrics import case_metrics
from reports.page.build import environment, script_json
from reports.page.check import console_messages, run_browser
from reports.page.folder import TEMPLATE_FOLDER, three_script
from reports.page.geometry import COLOUR_STEPS, NO_VALUE, SCALES, colour_tables, pack, quantise_values
from reports.page.geometry import viewer_data, wall_values

BUNDLE = pathlib.Path("build/three.min.js")
RINGS_MM = np.linspace(0.0, 40.0, 65)  # rings of make_case's tubes: 20 points each, then both ends' centres


def test_values_on_the_wall_and_none_where_nothing_was_computed(make_case, tube):
    files = CaseFiles("tube", make_case())
    values = wall_values(files, vtp.points(vtp.read(files.deployed_lumen, "")))
    s = np.repeat(RINGS_MM, 20)
    moved, stented = tube("vci").radii(s) != tube("pre").radii(s), (s >= 12.0) & (s <= 30.0)
    stretch, gap = values["stretch"][:-2], values["gap"][:-2]
    assert stretch[moved] == pytest.approx((tube("vci").radii(s) / tube("pre").radii(s))[moved])
    assert np.isnan(stretch[~moved]).all() and 0 < moved.sum() < len(s)
    assert gap[stented] == pytest.approx(np.where(s == 20.0, 0.5, 0.0)[stented])
    assert np.isnan(gap[~stented]).all()


def test_the_viewer_has_the_wall_of_vci_alone_with_fixed_scales(make_case):
    files = CaseFiles("tube", make_case())
    data = viewer_data(files, case_metrics(files))
    assert data["scales"] == SCALES
    assert [state for state, packed in data["states"].items() if "stretch" in packed and "gap" in packed] == ["vci"]
    for scale in SCALES.values():
        assert scale["limit"] == pytest.approx(0.5 * (scale["low"] + scale["high"]))
    red, _, blue = np.array(colour_tables()["limit"]).T
    assert (blue > red)[4 : COLOUR_STEPS // 2].all() and (red > blue)[COLOUR_STEPS // 2 :].all()


def test_without_a_stent_there_is_no_gap_to_show(make_case):
    folder = make_case()
    for path in (folder / "vci" / "devices").glob("*"):
        path.unlink()
    lumen = vtp.read(folder / "vci" / "lumen.vtp", "")
    vtp.add_array(lumen.GetPointData(), "malapposition_mm", np.zeros(lumen.GetNumberOfPoints()))
    vtp.write(folder / "vci" / "lumen.vtp", lumen)
    assert set(wall_values(CaseFiles("tube", folder), np.zeros((1, 3)) + 5.0)) <= {"stretch"}


VALUES = """
const fs = require("fs"), vm = require("vm");
globalThis.window = globalThis;
for (const file of process.argv.slice(1, 3)) vm.runInThisContext(fs.readFileSync(file, "utf8"));
const { packed, low, high } = JSON.parse(fs.readFileSync(0, "utf8"));
console.log(JSON.stringify(Array.from(window.vciViewer.unpackValues(packed, low, high))));
"""


@pytest.mark.skipif(shutil.which("node") is None, reason="the package nodejs is not installed")
def test_the_viewer_unpacks_values_and_gaps_between_them():
    values = np.array([1.0, np.nan, 1.5, 4.0, np.nan])
    steps = quantise_values(values, 1.0, 4.0)
    assert (steps == NO_VALUE).tolist() == np.isnan(values).tolist()
    command = ["node", "-e", VALUES, BUNDLE, TEMPLATE_FOLDER / "viewer.js"]
    text = json.dumps({"packed": pack(steps), "low": 1.0, "high": 4.0})
    done = subprocess.run(command, input=text, text=True, capture_output=True)
    assert done.returncode == 0, done.stderr
    found = [np.nan if value is None else value for value in json.loads(done.stdout)]
    assert found == pytest.approx(values, abs=1e-4, nan_ok=True)


DRIVER = """
const stage = window.vciStage(), viewer = document.querySelector(".viewer"), found = {};
const press = (key) => {
  const event = new KeyboardEvent("keydown", { key, bubbles: true, cancelable: true });
  viewer.querySelector(".stage").dispatchEvent(event);
  return event.defaultPrevented;
};
const camera = () => stage.view.camera.position.clone().sub(stage.controls.target);
const choose = (role, value) => {
  const item = viewer.querySelector(`[data-role=${role}]`);
  item.value = value;
  item.dispatchEvent(new Event("input"));
};
stage.show(viewer);
const start = camera();
viewer.querySelector(".stage").focus();
found.focused = document.activeElement.className;
found.degrees = {};
for (const key of ["ArrowLeft", "ArrowRight", "ArrowUp", "ArrowDown"]) {
  const before = camera();
  found.handled = press(key);
  found.degrees[key] = (Math.acos(before.dot(camera()) / before.length() / camera().length()) * 180) / Math.PI;
}
found.length = camera().length() / start.length();
press("+");
found.nearer = camera().length() / start.length();
press("-");
press("-");
found.farther = camera().length() / start.length();
press("0");
found.reset = camera().distanceTo(start);
found.tab = press("Tab");
choose("colour", "stretch");
found.legend = viewer.querySelector(".legend").textContent;
found.label = viewer.querySelector(".stage").getAttribute("aria-label");
found.hint = document.getElementById(viewer.querySelector(".stage").getAttribute("aria-describedby")).textContent;
const ownText = (item) => [...item.childNodes].filter((node) => node.nodeType === Node.TEXT_NODE)
  .map((node) => node.textContent.trim()).join("");
const named = (item) => item.ariaLabel || ownText(item.closest("label") || item);
const controls = [...viewer.querySelectorAll("select, input, button")];
found.unnamed = controls.filter((item) => !/[a-z]/i.test(named(item))).length;
const array = stage.view.states.pre.shape.getAttribute("color").array;
found.neutral = array.every((value) => value === array[0]);
const result = document.createElement("pre");
result.textContent = JSON.stringify(found);
document.body.append(result);
"""


@pytest.mark.slow
@pytest.mark.skipif(shutil.which("chromium") is None, reason="the package chromium is not installed")
def test_the_keyboard_turns_zooms_and_resets(make_case, tmp_path):
    files = CaseFiles("tube", make_case())
    metrics = case_metrics(files)
    data = viewer_data(files, metrics)
    case = {"id": "case-tube", "name": "tube", "pictured": list(metrics["states"]), "viewer": data, "still": ""}
    block = environment().get_template("viewer.html.j2").render(case=case, labels=LABELS)
    document = script_json({"cases": {"case-tube": data}, "colours": colour_tables()})
    scripts = [
        three_script(BUNDLE),
        *((TEMPLATE_FOLDER / name).read_text() for name in ("viewer.js", "stage.js")),
        DRIVER,
    ]
    page = f'<body><style>.stage {{ width: 600px; height: 300px; }}</style>{block}<script id="viewer-data" type='
    page += f'"application/json">{document}</script>' + "".join(f"<script>{script}</script>" for script in scripts)
    (tmp_path / "page.html").write_text(f"<!DOCTYPE html><html><meta charset='utf-8'>{page}</body></html>")
    dom, log = run_browser(tmp_path / "page.html", "--dump-dom")
    assert console_messages(log) == []
    found = json.loads(re.search("<pre>(.*)</pre>", dom)[1])
    assert found["focused"] == "stage live" and found["handled"] and not found["tab"]
    assert list(found["degrees"].values()) == pytest.approx([10.0] * 4, abs=0.01)
    assert found["length"] == pytest.approx(1.0) and found["nearer"] < 0.9 < 1.1 < found["farther"]
    assert found["reset"] < 1e-6 and found["unnamed"] == 0 and found["neutral"]
    assert "Wall stretch" in found["legend"] and "Beyond 1.5" in found["legend"] and "no value" in found["legend"]
    assert "Before PCI" in found["label"] and "wall stretch" in found["label"] and "arrow keys turn" in found["hint"]
