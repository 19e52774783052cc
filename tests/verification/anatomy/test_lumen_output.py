"""The output of `lumen`: it is complete or absent, no other process's file is touched, and names that cannot be written
are refused."""

import resource
import subprocess

import pytest
import surfaces

from vci.benchmarks import scenes


def test_a_surface_cut_short_is_no_result(binary, tmp_path):
    scenes.write_geometry(tmp_path, scenes.Tube(length=16, edge=0.8))
    command = [str(binary("lumen")), "remesh", str(tmp_path / "lumen.vtp"), "--edge", "0.8", "--out"]
    files = [tmp_path / "whole" / f"surface.{kind}" for kind in ("vtp", "stl")]
    files[0].parent.mkdir()
    for whole in files:
        assert subprocess.run([*command, str(whole)], capture_output=True, timeout=100).returncode == 0
        limit = whole.stat().st_size - 1

        def shorten(limit=limit):
            resource.setrlimit(resource.RLIMIT_FSIZE, (limit, limit))

        cut = tmp_path / "cut" / whole.name
        cut.parent.mkdir(exist_ok=True)
        result = subprocess.run(
            [*command, str(cut)],
            text=True,
            capture_output=True,
            timeout=100,
            preexec_fn=shorten,
            restore_signals=False,  # a signal ignored: a failed write, as on a full disk, instead of the program's end
        )
        assert result.returncode == 1 and "cannot be written" in result.stderr, result.stderr
        assert list(cut.parent.iterdir()) == []


@pytest.mark.parametrize("command, option", [("remesh", "--out"), ("check", "--repaired")])
def test_an_unknown_ending_is_refused_before_the_input_is_read(binary, tmp_path, command, option):
    missing, out = tmp_path / "missing.stl", tmp_path / "out.obj"
    done = subprocess.run([binary("lumen"), command, missing, option, out], text=True, capture_output=True)
    assert done.returncode == 2 and "unknown surface format" in done.stderr and "out.obj" in done.stderr


def test_two_runs_into_one_folder_do_not_share_files(process, tmp_path):
    """Temporary files of another process in the same folder are left alone."""
    surface = surfaces.write(tmp_path / "t.stl", *surfaces.tube(surfaces.straight, lambda s: 1.5 + 0 * s, 10))
    (tmp_path / "out").mkdir()
    other = tmp_path / "out" / ".partial-lumen.vtp"
    other.write_text("begun")
    process(surface, tmp_path / "out")
    assert other.read_text() == "begun" and (tmp_path / "out" / "lumen.vtp").exists()
    assert [path.name for path in (tmp_path / "out").glob(".partial-*")] == [other.name]


@pytest.mark.parametrize(
    "taper, options, doubted", [(0.0, (), True), (0.02, (), False), (0.0, ("--inlet", "0,0,0"), False)]
)
def test_check_says_where_the_inlet_is_chosen_by_its_width_alone(binary, tmp_path, taper, options, doubted):
    surface = surfaces.write(tmp_path / "t.stl", *surfaces.tube(surfaces.straight, lambda s: 1.5 - taper * s, 20))
    command = [str(binary("lumen")), "check", str(surface), "--units", "mm", *options]
    done = subprocess.run(command, text=True, capture_output=True)
    assert done.returncode == 0 and "inlet: " in done.stdout, done.stderr
    assert ("warning: the inlet is chosen by its width alone: it is 2.9" in done.stdout) == doubted, done.stdout
