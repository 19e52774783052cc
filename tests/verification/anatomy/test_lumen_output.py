"""A surface that `lumen` cannot write whole is refused: VTK's writer alone reports success."""

import resource
import subprocess

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
        assert result.returncode == 2 and "cannot be written" in result.stderr, result.stderr
        assert list(cut.parent.iterdir()) == []
