"""Scenes that ask for something impossible are refused before any stage, with a message that names the place."""

import json
import subprocess

import pytest
import yaml

from vci.benchmarks import scenes

TUBE = scenes.Tube(length=24, edge=1.2, lesion_length=6)


@pytest.fixture
def scene(tmp_path):
    """(document of scene.json, its path)."""
    path = scenes.write_scene(tmp_path / "case", TUBE, length=8.0, numerics={"device_edge_mm": 1.0})
    return json.loads(path.read_text()), path


def refusal(binary, scene):
    document, path = scene
    path.write_text(json.dumps(document))
    command = [str(binary("vci")), "deploy", str(path), "--out", str(path.parent / "out")]
    result = subprocess.run(command, text=True, capture_output=True, timeout=100)
    assert result.returncode == 2, (result.returncode, result.stderr[-500:])
    assert "residual" not in result.stderr, "a stage was computed"
    assert not (path.parent / "out" / "deployment.json").exists()
    return result.stderr


def device(document, step):
    return document["procedure"][step]["devices"][0]


@pytest.mark.parametrize("step, centre", [(0, 22.0), (1, 20.5), (1, 3.0), (2, 22.5)])
def test_a_device_past_the_end_of_the_vessel(binary, scene, step, centre):
    device(scene[0], step)["centre_s_mm"] = centre
    message = refusal(binary, scene)
    assert "past the end of its branch" in message
    assert f"{scene[1]}: scene.procedure[{step}].devices[0] (step" in message


def test_a_segment_past_the_branch(binary, scene):
    scene[0]["segment"] = {"branch": "main", "s_start_mm": 5, "s_end_mm": 26}
    message = refusal(binary, scene)
    assert "segment reaches past its branch" in message and f"{scene[1]}: scene.segment" in message


def test_a_pressure_beyond_the_chart_that_the_chart_may_still_say(binary, scene):
    """The balloon is rated 20 bar and its chart ends at 26. 25 bar are within both limits, 27 are not."""
    device(scene[0], 2)["pressure_bar"] = 27
    assert "end of the balloon's chart" in refusal(binary, scene)
    device(scene[0], 2)["pressure_bar"] = 25
    device(scene[0], 2)["device"] = "none"  # now the unknown device is refused, not the pressure
    assert "does not define" in refusal(binary, scene)


@pytest.mark.parametrize("step, action", [(1, "predilatation"), (1, "postdilatation"), (0, "stent"), (2, "stent")])
def test_stents_and_balloons_in_each_others_steps(binary, scene, step, action):
    scene[0]["procedure"][step]["action"] = action
    wrong = "a stent in a step" if step == 1 else "a balloon in a stent's step"
    assert wrong in refusal(binary, scene)


def test_a_balloon_too_wide_for_the_stent(binary, scene):
    """The balloon is refused inside the stent, and where it only reaches into the stent. Beside the stent it dilates
    the vessel alone, which is allowed."""
    document = scene[0]
    document["devices"]["stent"]["maximal_diameter_mm"] = 3.2  # the postdilatation opens to 3.26 mm at 16 bar
    assert "beyond its maximal diameter" in refusal(binary, scene)
    device(document, 2)["centre_s_mm"] = 12 + 4 + 2.5
    assert "beyond its maximal diameter" in refusal(binary, scene)
    device(document, 2)["centre_s_mm"] = 12 + 4 + 4
    document["segment"] = {"branch": "main", "s_start_mm": 5, "s_end_mm": 26}  # now only the segment is refused
    assert "segment" in refusal(binary, scene)
    device(document, 1)["pressure_bar"] = 16
    assert "beyond its maximal diameter" in refusal(binary, scene), "by its own balloon"


@pytest.mark.parametrize("name", ["../../escape", "a/b", ".hidden", ""])
def test_a_name_that_is_no_file(binary, scene, tmp_path, name):
    scene[0]["procedure"][0]["name"] = name
    assert "cannot be a file's" in refusal(binary, scene)
    assert not (tmp_path.parent / "escape_balloon.vtp").exists()


def test_two_steps_of_one_name(binary, scene):
    scene[0]["procedure"][2]["name"] = "predilatation"
    assert "two steps of one name" in refusal(binary, scene)


def test_a_stent_named_like_a_balloons_file(binary, scene):
    """The name of a device does not decide its kind: each shape is written under its own kind."""
    document, path = scene
    document["devices"]["predilatation_balloon"] = document["devices"].pop("stent")
    device(document, 1)["device"] = "predilatation_balloon"
    path.write_text(json.dumps(document))
    command = [str(binary("vci")), "deploy", str(path), "--out", str(path.parent / "out")]
    result = subprocess.run(command, text=True, capture_output=True, timeout=100)
    assert result.returncode == 0, result.stderr[-500:]
    written = {f.stem for f in (path.parent / "out" / "devices").iterdir()}
    balloons = {f"{name}_balloon" for name in ("predilatation", "stent 1", "postdilatation")}
    assert written == balloons | {"stent1", "stent1_struts"}


def test_results_that_would_replace_the_scene_s_own_files(binary, scene):
    """The lumen of the generated scene is the file lumen.vtp in the same folder."""
    document, path = scene
    kept = path.parent / document["lumen"]
    before = kept.read_bytes()
    for command in ("deploy", "radius-correct"):
        result = subprocess.run(
            [str(binary("vci")), command, str(path), "--out", str(path.parent)], text=True, capture_output=True
        )
        assert result.returncode == 2 and "would replace what they are made of" in result.stderr
        assert kept.read_bytes() == before and path.exists()


def test_an_earlier_runs_results_go_and_other_files_stay(binary, scene):
    document, path = scene
    out = path.parent / "out"
    (out / "devices").mkdir(parents=True)
    for name in ("lumen.vtp", "deployment.json", "devices/old.vtp", "devices/mine.yaml", "notes.txt"):
        (out / name).write_text("x")
    document["centreline"] = "missing.vtp"
    path.write_text(json.dumps(document))
    result = subprocess.run([str(binary("vci")), "deploy", str(path), "--out", str(out)], capture_output=True)
    assert result.returncode == 2
    left = {str(f.relative_to(out)) for f in out.rglob("*") if f.is_file()}
    assert left == {"devices/mine.yaml", "notes.txt"}


@pytest.mark.parametrize(
    "section, key, value, words",
    [
        ("numerics", "fixed_step_ms", 0.001, "a setting of textbook integration"),
        ("numerics", "velocity_stop_mm_per_ms", 0.5, "a setting of textbook integration"),
        ("wall", "spring_mapping", "van_gelder", "a mapping to springs"),
    ],
)
def test_a_setting_whose_method_is_not_chosen(binary, scene, section, key, value, words):
    scene[0].setdefault(section, {})[key] = value
    assert words in refusal(binary, scene)


def test_frames_of_steps_need_a_folder(binary, scene):
    command = [
        str(binary("vci")),
        "deploy",
        str(scene[1]),
        "--out",
        str(scene[1].parent / "out"),
        "--frames-every",
        "3",
    ]
    result = subprocess.run(command, text=True, capture_output=True, timeout=100)
    assert result.returncode == 2 and "--frames" in result.stderr


@pytest.mark.parametrize("number", ["0", "-3", "1.5", "99999999999"])
def test_a_number_of_steps_that_is_none(binary, scene, number):
    """The message is short. CLI11's own check for positive numbers would write out the largest double."""
    out = scene[1].parent / "out"
    command = [str(binary("vci")), "deploy", str(scene[1]), "--out", str(out), "--frames", str(out / "f")]
    result = subprocess.run([*command, f"--frames-every={number}"], text=True, capture_output=True, timeout=100)
    assert result.returncode == 2 and "--frames-every" in result.stderr and not out.exists()
    assert max(len(line) for line in result.stderr.splitlines()) < 150, result.stderr


def catalogue_limits(repo_root, kind):
    """{key: [least, largest]} of the numbers in the schema of a device family; for stents also those of a design."""
    schema = yaml.safe_load((repo_root / f"config/schemas/{kind}.schema.yaml").read_text())["properties"]
    numbers = schema | (schema["designs"]["items"]["properties"] if kind == "stent" else {})
    return {key: [entry["minimum"], entry["maximum"]] for key, entry in numbers.items() if "maximum" in entry}


@pytest.mark.parametrize("kind, least_keys", [("balloon", 4), ("stent", 9)])
def test_the_engine_takes_what_the_catalogue_takes(binary, scene, repo_root, kind, least_keys):
    """The catalogue's limits of each number of a device are within the engine's limits. Otherwise a plan could pass the
    catalogue and be refused only by the engine, after the anatomy step."""
    document, _ = scene
    entry = next(entry for entry in document["devices"].values() if entry["kind"] == kind)
    limits = catalogue_limits(repo_root, kind)
    limits.pop("up_to_diameter_mm", None)  # chooses the design, and is in no scene
    if kind == "stent":
        limits["maximal_diameter_mm"][0] = entry["nominal_diameter_mm"]  # the catalogue refuses smaller ones, too
    assert len(limits) >= least_keys
    for key, ends in limits.items():
        before = entry.get(key)
        for value in ends:
            entry[key] = value
            assert "out of its range" not in refusal_of_reading(binary, scene), (key, value)
        entry[key] = 1e9
        assert "out of its range" in refusal_of_reading(binary, scene), f"{key} is read"
        if before is None:
            del entry[key]
        else:
            entry[key] = before


def refusal_of_reading(binary, scene):
    """The first refusal of the scene, whose last step names a missing device. The devices are checked before that."""
    device(scene[0], 2)["device"] = "none"
    return refusal(binary, scene)
