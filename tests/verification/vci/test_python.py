"""The engine from Python. The code of docs/python.md runs as printed there; arrays, errors, threads and logs work."""

import json
import os
import pathlib
import re
import subprocess
import sys
import threading
import time

import numpy as np
import pytest

import vci
from common import vtp
from vci.benchmarks.scenes import Tube, balloon, stent, write_scene

ROOT = pathlib.Path(__file__).resolve().parents[3]
PAGE = ROOT / "docs" / "python.md"

pytest.importorskip("vci._engine", reason="the Python module is not built: run make build")


def page_blocks():
    """[(code, its printed output)] of the page."""
    return re.findall(r"```python\n(.*?)```\n(?:```text\n(.*?)```)?", PAGE.read_text(), re.S)


def test_page_prints_what_it_says(capsys):
    names = {}
    for code, printed in page_blocks():
        exec(compile(code, str(PAGE), "exec"), names)
        assert capsys.readouterr().out == printed
    assert len(names["result"].devices) == 3


def test_page_lists_every_name():
    """The page's table of names has exactly the names that the package offers."""
    table = PAGE.read_text().partition("## Names")[2].partition("\n## ")[0]
    listed = set(
        re.findall(r"`([A-Za-z_]+(?:\.[a-z_]+)?)(?:\(.*?\))?`", "".join(re.findall(r"^\| (`.*?) \| ", table, re.M)))
    )
    offered = set(vci.__all__)
    for name in vci.__all__:
        if isinstance(getattr(vci, name), type) and not issubclass(getattr(vci, name), Exception):
            offered |= {f"{name}.{inner}" for inner in vars(getattr(vci, name)) if not inner.startswith("_")}
    classes = {"Result", "Device"}  # users do not construct these, so the page lists only their attributes
    assert listed == offered - classes


@pytest.fixture(scope="module")
def vessel():
    """A short narrowed tube, from arrays."""
    return lumen_of(Tube(length=20, lesion_length=7, edge=0.8))


def lumen_of(tube, **changes):
    points, triangles, radius, plaque, kind = tube.mesh()
    axis = tube.centre(np.linspace(0, tube.length, int(4 * tube.length) + 1))
    given = {"points": points, "triangles": triangles, "radius_mm": radius, "centreline": {"main": axis}}
    given |= {"plaque_thickness_mm": plaque, "plaque_type": kind}
    return vci.Lumen(**(given | changes))


DEVICES = {"b": balloon(2.5, 8), "d": balloon(3.0, 10), "s": stent(3.0, 10, "d")}


def step(name="first", device="b", action="predilatation", **changes):
    return {
        "name": name,
        "action": action,
        "devices": [{"device": device, "centre_s_mm": 10, "pressure_bar": 10} | changes],
    }


STEPS = [step(), step("second", "s", "stent", pressure_bar=11)]


def test_a_coarse_lumen_moves_the_fine_one(vessel):
    """The fine lumen keeps its points' order, and its areas agree with a deployment without the coarse lumen. A
    Deployment gives the same points as one call."""
    coarse = lumen_of(Tube(length=20, lesion_length=7, edge=1.1))
    alone, carried = (vci.deploy(vessel, DEVICES, STEPS, coarse_lumen=given) for given in (None, coarse))
    assert carried.points.shape == vessel.points.shape and np.array_equal(carried.triangles, alone.triangles)
    assert len(carried.wall_stretch) == len(carried.malapposition_mm) == len(vessel.points)
    assert len(carried.forces["contact_n"]) == len(coarse.points)
    areas = [[row["area_mm2"] for row in one.readouts["csa_profile"]] for one in (alone, carried)]
    assert np.mean(areas[1]) == pytest.approx(np.mean(areas[0]), rel=0.02) and areas[0] != areas[1]
    watched = vci.Deployment(vessel, DEVICES, STEPS, coarse_lumen=coarse)
    watched.run()
    assert np.array_equal(watched.points, carried.points)


def test_a_coarse_lumen_of_another_vessel_is_refused(vessel):
    other = lumen_of(Tube(length=20, lesion_length=7, edge=1.1, radius=4.0))
    with pytest.raises(vci.InputError, match="coarse_lumen is not this lumen.*\n.*argument coarse_lumen"):
        vci.deploy(vessel, DEVICES, STEPS, coarse_lumen=other)


DEPLOY_ARRAYS_SCRIPT = """
import json, sys
import numpy as np
import vci
folder = sys.argv[1]
entries = json.load(open(f"{folder}/scene.json"))
lumen = vci.Lumen.read(f"{folder}/lumen.vtp", f"{folder}/centreline.vtp")
settings = {key: entries.get(key, {}) for key in ("wall", "numerics")}
result = vci.deploy(lumen, entries["devices"], entries["procedure"], map_pa=entries["patient"]["map_pa"], **settings)
np.save(f"{folder}/points.npy", result.points)
json.dump(result.readouts, open(f"{folder}/readouts.json", "w"))
"""


def test_same_as_the_program(binary, tmp_path):
    """The program with a scene's files and the module with the same arrays give the same lumen.

    Python is started with the GLIBC_TUNABLES that the program sets for itself (docs/python.md).
    """
    scene = write_scene(tmp_path, Tube(length=20, lesion_length=7, edge=0.8))
    subprocess.run([binary("vci"), "deploy", scene, "--out", tmp_path / "out"], check=True, capture_output=True)
    environment = {**os.environ, "GLIBC_TUNABLES": "glibc.cpu.hwcaps=-FMA,-FMA4"}
    environment["PYTHONPATH"] = str(pathlib.Path(vci._engine.__file__).parents[1])
    subprocess.run([sys.executable, "-c", DEPLOY_ARRAYS_SCRIPT, tmp_path], check=True, env=environment, cwd=tmp_path)
    program = vtp.points(vtp.read_triangles(tmp_path / "out" / "lumen.vtp", ""))
    assert np.array_equal(program, np.load(tmp_path / "points.npy"))
    written, found = (json.loads((tmp_path / name).read_text()) for name in ("out/deployment.json", "readouts.json"))
    for key in set(written) - {"seconds", "peak_memory_mib", "stages", "case"}:
        assert found[key] == written[key], key


def test_steps_one_by_one(vessel):
    """The points change with each step, and the last state is that of a single call of vci.deploy."""
    deployment = vci.Deployment(vessel, DEVICES, STEPS)
    assert (deployment.steps, deployment.steps_done) == (2, 0)
    assert np.array_equal(deployment.points, vessel.points)
    deployment.step()
    between = deployment.points
    assert deployment.steps_done == 1 and not np.array_equal(between, vessel.points)
    deployment.run()
    once = vci.deploy(vessel, DEVICES, STEPS)
    assert np.array_equal(deployment.result().points, once.points)
    assert np.array_equal(deployment.points, once.points) and not np.array_equal(between, once.points)
    assert [device.kind for device in once.devices] == ["balloon", "balloon", "stent"]
    assert once.wall_stretch.shape == once.malapposition_mm.shape == (len(vessel.points),)
    assert once.forces["residual_n"].shape == vessel.points.shape and once.triangles.shape == vessel.triangles.shape
    with pytest.raises(RuntimeError):
        deployment.step()


def test_baseline_moves_the_wall(vessel):
    moved = vci.radius_correct(vessel, DEVICES, STEPS)
    assert np.linalg.norm(moved - vessel.points, axis=1).max() > 0.5


@pytest.mark.parametrize(
    "steps, words",
    [
        (
            [step(pressure_bar=39)],
            ["beyond the balloon's rated burst pressure", "procedure[0].devices[0].pressure_bar", "39"],
        ),
        ([step(device="none")], ["a device that the scene does not define", "none"]),
        ([step(centre_s_mm=19)], ["remedy"]),
        ([step(typo=1)], ["typo"]),
        ([step(pressure_bar=float("nan"))], ["not finite", "steps"]),
    ],
)
def test_bad_steps_are_refused_with_the_programs_words(vessel, steps, words):
    with pytest.raises(vci.InputError) as raised:
        vci.deploy(vessel, DEVICES, steps)
    assert isinstance(raised.value, ValueError)
    assert all(word in str(raised.value) for word in words), raised.value


def test_bad_arrays_are_refused():
    tube = Tube(length=20, lesion_length=7, edge=0.8)
    points, triangles, radius, _, _ = tube.mesh()
    for changes, words in (
        ({"radius_mm": radius[:-1]}, "radius"),
        ({"points": points * np.nan}, "not finite"),
        ({"triangles": triangles + len(points)}, "triangle"),
        ({"triangles": triangles + 0.5}, "whole numbers"),
        ({"triangles": triangles.astype(np.int64) + 2**33}, "out of its range"),
        ({"triangles": triangles[:, :2]}, r"\(m, 3\)"),
        ({"plaque_type": radius}, "whole numbers"),
        ({"centreline": {"side1": points[:5]}}, "main"),
        ({"reference_radius_mm": radius - 9}, "reference_radius"),
        ({"branch_id": np.zeros(3, int)}, "branch_id"),
        ({"branch_id": np.zeros(len(triangles))}, "whole numbers"),
    ):
        with pytest.raises(vci.InputError, match=words):
            lumen_of(tube, **changes)
    with pytest.raises(TypeError):
        lumen_of(tube, points=points[:, :2])
    assert np.array_equal(lumen_of(tube, triangles=triangles.tolist()).triangles, triangles)
    with pytest.raises(vci.InputError, match="no such file"):
        vci.Lumen.read("nowhere.vtp", "nowhere.vtp")


def test_a_stage_without_balance_raises(vessel):
    with pytest.raises(vci.ComputationError, match="did not reach force balance") as raised:
        vci.deploy(vessel, DEVICES, STEPS, numerics={"maximal_steps_per_stage": 2})
    assert isinstance(raised.value, RuntimeError) and "remedy" in str(raised.value)


def test_log_and_its_errors(vessel):
    """Lines go to the caller's function, which may look at the state or end the run by an exception."""
    lines, deployment = [], None
    deployment = vci.Deployment(
        vessel, DEVICES, STEPS, log=lambda line: lines.append((line, deployment and deployment.steps_done))
    )
    deployment.step()
    assert lines and all(isinstance(line, str) for line, _ in lines) and lines[-1][1] in (0, 1)

    def stop(line):
        raise KeyboardInterrupt(line)

    with pytest.raises(KeyboardInterrupt):
        vci.deploy(vessel, DEVICES, STEPS, log=stop)


def test_threads_run_on(vessel):
    """Other threads run while a deployment computes. Two deployments at the same time give equal results."""
    found, counted = [], 0
    workers = [
        threading.Thread(target=lambda: found.append(vci.deploy(vessel, DEVICES, STEPS).points)) for _ in range(2)
    ]
    for worker in workers:
        worker.start()
    while any(worker.is_alive() for worker in workers):
        time.sleep(1e-3)
        counted += 1
    assert counted > 20  # had the workers held the interpreter, this thread would have counted once or twice
    assert np.array_equal(*found)


INTERRUPT_SCRIPT = """
import signal, sys, threading, time
sys.path[:0] = sys.argv[1:]  # as of the test
import vci
from test_python import DEVICES, STEPS, Tube, lumen_of
signal.signal(signal.SIGINT, signal.default_int_handler)  # a shell's background job ignores it
fine = lumen_of(Tube(length=20, lesion_length=7, edge=0.3))
began = time.monotonic()
vci.deploy(fine, DEVICES, STEPS)
whole = time.monotonic() - began
threading.Timer(0.2 * whole, signal.raise_signal, [signal.SIGINT]).start()
began = time.monotonic()
try:
    vci.deploy(fine, DEVICES, STEPS)
except KeyboardInterrupt:
    print("interrupted", "early" if time.monotonic() - began < 0.7 * whole else "at the end")
"""


def test_interrupt_ends_a_computation():
    """Ctrl-C ends a run early, not only at its end.

    Python delivers it to the main thread. A test may run in another thread, so this one starts a process.
    """
    command = [sys.executable, "-c", INTERRUPT_SCRIPT, str(pathlib.Path(__file__).parent), *sys.path]
    process = subprocess.run(command, cwd=ROOT, capture_output=True, text=True)
    assert process.stdout.strip() == "interrupted early", process.stderr


def test_arguments_of_other_kinds(vessel):
    """Tuples and numpy's numbers are accepted like lists and numbers. Other objects are refused."""
    once = vci.deploy(vessel, DEVICES, STEPS[:1])
    numbers = {"b": dict(balloon(2.5, 8), length_mm=np.int64(8), nominal_diameter_mm=np.float64(2.5))}
    assert np.array_equal(vci.deploy(vessel, numbers, tuple(STEPS[:1])).points, once.points)
    with pytest.raises(TypeError, match="neither a number"):
        vci.deploy(vessel, {"b": object()}, STEPS[:1])


def test_without_the_compiled_module(tmp_path):
    """Without the compiled module the benchmarks can be imported. Its names raise an error with the command to build
    it."""
    script = "import vci.benchmarks.scenes, vci\ntry: vci.deploy\nexcept ImportError as error: print(error)"
    process = subprocess.run(
        [sys.executable, "-c", script], cwd=ROOT, env={"PATH": "/usr/bin"}, capture_output=True, text=True
    )
    assert "make build" in process.stdout, process.stderr
