"""A failing run of `vci deploy` leaves a message, an exit code and no results."""

import json
import os
import resource
import subprocess

import pytest

from vci.benchmarks import scenes

TUBE = scenes.Tube(length=24, edge=1.2, lesion_length=6)
NUMERICS = {"device_edge_mm": 1.0}


def scene_in(folder):
    return scenes.write_scene(folder / "case", TUBE, length=6.0, numerics=NUMERICS)


def deploy(binary, scene, out, largest_file=None):
    """Runs the program; files longer than `largest_file` bytes cannot be written."""

    def limit():
        resource.setrlimit(resource.RLIMIT_FSIZE, (largest_file, largest_file))

    return subprocess.run(
        [str(binary("vci")), "deploy", str(scene), "--out", str(out)],
        text=True,
        capture_output=True,
        timeout=100,
        preexec_fn=limit if largest_file else None,
        # Python ignores SIGXFSZ, and the program inherits this. A write beyond the limit then fails as on a full disk,
        # instead of ending the program.
        restore_signals=False,
    )


@pytest.fixture(scope="module")
def complete_run(binary, tmp_path_factory):
    """(scene, {name: size in bytes} of the files of a run without a limit)."""
    folder = tmp_path_factory.mktemp("output")
    scene = scene_in(folder)
    assert deploy(binary, scene, folder / "out").returncode == 0
    return scene, {f.name: f.stat().st_size for f in (folder / "out").rglob("*") if f.is_file()}


@pytest.mark.slow
def test_a_file_cut_short_is_no_result(binary, complete_run, tmp_path):
    """The limit is a byte below the size of each file in turn, then very small. The failed write must be reported."""
    scene, sizes = complete_run
    for limit in [*(size - 1 for size in sizes.values()), 1000, 50]:
        result = deploy(binary, scene, tmp_path / "out", limit)
        assert result.returncode == 1 and "cannot be written" in result.stderr, (limit, result.stderr[-500:])
        assert [f for f in (tmp_path / "out").rglob("*")] == [], limit


def test_deployment_json_cut_short(binary, complete_run, tmp_path):
    """A very long case name makes deployment.json the longest file, so that the limit stops this file only."""
    scene, sizes = complete_run
    document = json.loads(scene.read_text())
    document["case"] = "x" * (2 * max(sizes.values()))
    wordy = scene.with_name("wordy.json")
    wordy.write_text(json.dumps(document))
    result = deploy(binary, wordy, tmp_path / "out", max(sizes.values()))
    assert result.returncode == 1 and "deployment.json" in result.stderr, result.stderr[-500:]
    assert not (tmp_path / "out" / "deployment.json").exists()


def test_a_folder_that_cannot_be_written_is_told_before_the_work(binary, tmp_path):
    scene = scene_in(tmp_path)
    (tmp_path / "file").write_text("")
    for out in (tmp_path / "file", tmp_path / "file" / "out"):
        result = deploy(binary, scene, out)
        assert result.returncode == 2 and "folder for results" in result.stderr, result.stderr
        assert "residual" not in result.stderr, "no stage was computed"


def test_a_scene_that_is_refused_leaves_no_results_of_another(binary, complete_run, tmp_path):
    scene, _ = complete_run
    assert deploy(binary, scene, tmp_path / "out").returncode == 0
    assert (tmp_path / "out" / "deployment.json").is_file()
    assert deploy(binary, tmp_path / "none.json", tmp_path / "out").returncode == 2
    assert not (tmp_path / "out" / "deployment.json").exists()


def test_what_a_signal_left_goes_at_the_next_run(binary, complete_run, tmp_path):
    """Partial results of a process that has ended are removed.

    The folder of a process that still runs stays, and so do folders whose names only look like partial results.
    """
    scene, _ = complete_run
    ended = subprocess.Popen(["true"])
    ended.wait()
    out = tmp_path / "out"
    stale, running = out / f".partial-{ended.pid}", out / f".partial-{os.getpid()}"
    others = [out / ".partial-mine", out / ".partial-", out / ".partial-12x"]
    for folder in (stale, running, *others):
        (folder / "devices").mkdir(parents=True)
    assert deploy(binary, scene, out).returncode == 0
    assert not stale.exists() and running.exists() and all(folder.exists() for folder in others)
    assert (out / "deployment.json").is_file()
