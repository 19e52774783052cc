"""The report: what it holds, that it stands alone, and that the check sees what is wrong with a page."""

import base64
import json
import re
import shutil

import pytest

from common.errors import ComputationError, InputError
from reports.__main__ import main
from reports.page.benchmarks import TITLES
from reports.page.check import run_browser, check_report, console_messages, outside_references
from reports.page.build import fixed, signed, signed_decimals, signed_significant, significant
from reports.page.evidence import evidence_rows, read_test_results

POLICY = '<meta http-equiv="Content-Security-Policy" content="default-src \'none\'">'
JUNIT = """<testsuites><testsuite>
<testcase classname="tests.verification.flow.test_poiseuille" name="test_drop" time="1.5"/>
<testcase classname="tests.verification.flow.test_poiseuille" name="test_fine"><skipped message="no mesh"/></testcase>
<testcase classname="tests.unit.vci.test_x" name="a" time="0.1"><failure message="1 != 2">trace</failure></testcase>
</testsuite></testsuites>"""
CASE_FILE = """kind: surface
description: a vessel
patient: {lvm_g: 150, sbp_mmhg: 120, dbp_mmhg: 80, territory: lad}
lumen: {path: artery.stl, units: mm}
plan: auto
"""
PNG = "iVBORw0KGgoAAAANSUhEUgAAAAEAAAABCAQAAAC1HAwCAAAAC0lEQVR42mNk+A8AAQUBAScY42YAAAAASUVORK5CYII="  # one pixel

needs_chromium = pytest.mark.skipif(shutil.which("chromium") is None, reason="the package chromium is not installed")


@pytest.fixture
def study(make_case, add_arm, tmp_path):
    """study(cases...) -> path of the report of cases (name, options)."""

    def make(*cases, junit=(), arm=False):
        folders = []
        for name, options in cases:
            folders.append(make_case(name, **options))
            out = str(folders[-1] / "metrics.json")
            of_case = ["metrics", "--case", name, "--case-dir", str(folders[-1])]
            main([*of_case, "--out", out])
            if arm:
                add_arm(folders[-1])
                found = str(folders[-1] / "half_maximum" / "metrics.json")
                main([*of_case, "--segmentation", "half_maximum", "--out", found])
        metrics = [str(folder / "metrics.json") for folder in folders]
        dirs = [str(folder) for folder in folders]
        for name in ("agreement", "cohort", "contrast", "nearer"):
            main([name, "--metrics", *metrics, "--out", str(tmp_path / "study" / f"{name}.csv")])
        arms = [folder / "half_maximum" / "metrics.json" for folder in folders]
        found = [str(path) for path in arms if path.exists()]
        main(["agreement", "--metrics", *found, "--out", str(tmp_path / "study" / "half_maximum.csv")])
        tables = ["--stations", str(tmp_path / "stations.csv"), "--out", str(tmp_path / "study" / "differences.csv")]
        main(["differences", "--metrics", *metrics, *tables])
        main(["timings", "--case-dir", *dirs, "--out", str(tmp_path / "study" / "timings.csv")])
        configs = [tmp_path / "configs" / f"{name}.yaml" for name, _ in cases]
        for config in configs:
            config.parent.mkdir(exist_ok=True)
            config.write_text(CASE_FILE)
        selection = [
            "--inclusion",
            str(tmp_path / "study" / "inclusion.csv"),
            "--figures-dir",
            str(tmp_path / "figures"),
        ]
        out = ["--out", str(tmp_path / "study" / "patients.csv")]
        main(["patients", "--metrics", *metrics, "--configs", *map(str, configs), *selection, *out])
        seconds = ["--out", str(tmp_path / "study" / "seconds.csv"), "--figures-dir", str(tmp_path / "figures")]
        main(["seconds", "--timings", str(tmp_path / "study" / "timings.csv"), *seconds])
        main(["figures", "--case-dir", *dirs, "--metrics", *metrics, "--out-dir", str(tmp_path / "figures")])
        paths = [tmp_path / "index.html", tmp_path / "again.html"]
        for path in paths:
            places = ["--study-dir", str(tmp_path / "study"), "--figures-dir", str(tmp_path / "figures")]
            more = ["--junit", *map(str, junit)] if junit else []
            main(["report", "--case-dir", *dirs, *places, *more, "--cohort", "quick", "--out", str(path)])
        assert paths[0].read_bytes() == paths[1].read_bytes()
        return paths[0]

    return make


@pytest.mark.slow
def test_report_of_a_case_with_and_one_without_reference(study, tmp_path):
    (tmp_path / "junit.xml").write_text(JUNIT)
    path = study(("tube", {}), ("own", {"states": ("pre", "vci")}), junit=[tmp_path / "junit.xml"])
    text = path.read_text()
    assert outside_references(text) == []
    for words in (
        'id="case-tube"',
        'id="case-own"',
        "error of the <b>method</b> alone",
        "test_poiseuille",
        "its prediction is untested",
        "<li>stub left closed: at (1, 2, 3)</li>",
        "elements 0.31 %",
        "slice spacing mm 1.0 instead of 0.75.",
        '<td class="text">balloon-extraction</td>',
        "Along the stent: Diff<sup>A</sup> and Diff<sup>C</sup>",
        "Case by case: where the two methods part",
        "Minimal stent area 7.30 mm²; smallest lumen within the stent 7.05 mm²",
        "<li>stent: opened beyond its maximal diameter</li>",
    ):
        assert words in text, words
    assert text.count('class="viewer"') == 2 and text.count("49.8 % only") == text.count("stub left closed") == 4
    if shutil.which("chromium"):
        check_report(path, tmp_path / "shot.png")
        assert (tmp_path / "shot.png").stat().st_size > 20000
        page, _ = run_browser(path, "--dump-dom", anchor="case-tube")
        assert page.count("<canvas") == 1 and 'class="stage live"' in page


@pytest.mark.slow
def test_report_with_ct_keeps_four_errors_apart_and_shows_the_warnings(study):
    message = "main 18.0-21.0 mm: contrast on the axis falls to 0.41"
    warning = {"code": "occluded_by_voxels", "branch": "main", "message": message}
    states = ("pre", "vci", "rc", "reference", "ct", "ct_vci", "ct_rc")
    path = study(("tube", {"states": states, "warnings": [warning]}), ("other", {"states": states, "change": 0.02}))
    text = path.read_text()
    for words in ("Four errors are kept apart", "All together (clinical)", "CT of the reference − reference"):
        assert words in text, words
    assert text.count(message) == 4, "two images: each with its case and among the limits"
    assert text.count("no warning.") == 2
    clinical = next(row for row in text.split("<tr>") if "VCI from CT − CT" in row and "Mean CSA" in row)
    assert "−5.22 to +2.12" in clinical
    assert text.count("−5.22 to +2.12") == 1
    assert (
        '<option value="ct">' in text and '<option value="ct_vci"' not in text
    ), "too like the others in three dimensions"
    if shutil.which("chromium"):
        check_report(path)


@pytest.mark.slow
def test_both_segmentations_stand_on_the_page_and_who_is_not_included(study):
    states = ("pre", "vci", "rc", "reference", "ct", "ct_vci", "ct_rc")
    path = study(("tube", {"states": states}), ("mild", {"states": states, "change": -0.2}), arm=True)
    text = path.read_text()
    assert "How the lumen is found in the image" in text and "with an error of up to 0.0030" in text
    assert "The statistics are of the 1 included patient:" in text
    assert re.search(r'Not included is <a href="#case-mild">mild</a> \(FFR before PCI 0\.[89]\d\)', text)
    assert text.count("<details><summary>The same for the patients that are not included") == 1
    table = text.split("How the lumen is found in the image")[1].split("</table>")[0]
    clinical = next(row for row in table.split("<tr>") if "<th>FFR</th>" in row)
    # predicted minus after PCI, of the network's FFR, and the published one beside it
    assert "<td>−0.040</td>" in clinical and "−0.02 ± 0.05" in clinical


@pytest.mark.slow
def test_warnings_of_the_flow_are_shown_with_case_and_state(study, tmp_path):
    path, folder = study(("tube", {})), tmp_path / "cases" / "tube"
    assert "Doubtful FFR" not in path.read_text()
    file = folder / "flow" / "rc" / "ffr.json"
    message = "FFR at the probe distal depends on its place: it still rises by 0.0016 a mm"
    file.write_text(json.dumps(json.loads(file.read_text()) | {"warnings": [message]}))
    places = ["--study-dir", str(tmp_path / "study"), "--figures-dir", str(tmp_path / "figures")]
    main(["report", "--case-dir", str(folder), *places, "--out", str(path)])
    text = path.read_text()
    assert f"<li><b>Radius correction</b>: {message}</li>" in text
    assert f'<a href="#case-tube">tube</a> (rc), {message}.' in text
    assert text.count(message) == 2, "with its case and among the limits, of this state alone"


@pytest.mark.slow
def test_report_without_any_reference_or_tests_says_so(study):
    text = study(("own", {"states": ("pre", "vci")})).read_text()
    assert "No case of this run has a reference" in text
    assert "carries no evidence of verification" in text and "Diff<sup>A</sup>" not in text


@pytest.mark.slow
@pytest.mark.parametrize("ffr, eps, above, stars", [(0.86, 0.0, 1, 0), (0.72, 0.004, 0, 2)])
def test_a_mild_narrowing_and_a_modified_flow_are_said(study, tmp_path, ffr, eps, above, stars):
    path, folder = study(("tube", {})), tmp_path / "cases" / "tube"
    for file, keys, value in (
        (folder / "metrics.json", ("states", "pre", "ffr", "distal"), ffr),
        (folder / "flow" / "pre" / "ffr.json", ("artificial_viscosity",), eps),
    ):
        document = entry = json.loads(file.read_text())
        for key in keys[:-1]:
            entry = entry[key]
        entry[keys[-1]] = value
        file.write_text(json.dumps(document))
    agreement = str(tmp_path / "study" / "agreement.csv")
    main(["agreement", "--metrics", str(folder / "metrics.json"), "--out", agreement])
    places = ["--study-dir", str(tmp_path / "study"), "--figures-dir", str(tmp_path / "figures")]
    main(["report", "--case-dir", str(folder), *places, "--out", str(path)])
    text = path.read_text()
    assert text.count("above 0.80, where a narrowing is usually left alone") == above
    note = "* This FFR is of a flow with some artificial viscosity"
    assert text.count('<a href="#case-tube">*</a>') + text.count(note) == stars


@pytest.mark.slow
def test_benchmarks_that_were_run_are_shown(study, tmp_path):
    path, folder = study(("tube", {})), tmp_path / "cases" / "tube"
    assert 'id="benchmarks"' not in path.read_text()
    for name, table in (
        ("flow_hard_cases", "case,outcome,ffr,residual_n,reason,cpu_s\nsharp_bend,fine,0.5,1.23456e-9,,31\n"),
        ("another", "n,seconds\n20000,0.5\n"),
    ):
        (tmp_path / "benchmarks" / name).mkdir(parents=True)
        (tmp_path / "benchmarks" / name / "table.csv").write_text(table)
    (tmp_path / "benchmarks" / "another" / "pareto.png").write_bytes(base64.b64decode(PNG))
    places = ["--study-dir", str(tmp_path / "study"), "--figures-dir", str(tmp_path / "figures")]
    places += ["--benchmarks", str(tmp_path / "benchmarks")]
    main(["report", "--case-dir", str(folder), *places, "--out", str(path)])
    text = path.read_text()
    for words in ("<th>residual (N)</th>", "<td>1.235e-09</td>", "<td>0.5</td>", "<th>20000</th>", "sharp bend"):
        assert words in text, words
    for words in ('<th class="text">outcome</th>', '<td class="text">fine</td>', "<th>FFR</th>", "<th>CPU (s)</th>"):
        assert words in text, words
    assert ">reason</th>" not in text  # nothing in it
    assert text.index("Blood flow: hard cases") < text.index("<h3>another</h3>") and "data:image/webp" in text
    (tmp_path / "benchmarks" / "another" / "table.csv").write_text("")
    with pytest.raises(SystemExit):
        main(["report", "--case-dir", str(folder), *places, "--out", str(path)])


def test_every_benchmark_has_its_title_and_every_title_its_benchmark(repo_root):
    rules = (repo_root / "workflow" / "rules" / "benchmarks.smk").read_text()
    outputs = re.findall(r"\n    output:\n((?:        .*\n)+)", rules)
    shown = [re.findall(r'"results/benchmarks/(\w+)/[\w.]+\.(?:csv|png|svg)"', files) for files in outputs]
    assert len(shown) == len(re.findall(r"^rule (?!benchmarks:)", rules, re.M)) and all(shown)
    assert {name for names in shown for name in names} == set(TITLES)


@pytest.mark.slow
def test_both_tables_of_the_textbook_comparison_and_its_figure_are_shown(study, tmp_path):
    path, folder = study(("tube", {})), tmp_path / "benchmarks" / "deployment_baseline"
    folder.mkdir(parents=True)
    (folder / "baseline.csv").write_text(
        "case,scheme,outcome,reason\ncalcified,textbook,stopped,not done after 60 CPU s\n"
    )
    (folder / "levels.csv").write_text(
        "case,error_percent,textbook_edge_mm,times\ncalcified,3,1.0,43.21\n,1,not reached,\n"
    )
    (folder / "baseline.png").write_bytes(base64.b64decode(PNG))
    places = ["--study-dir", str(tmp_path / "study"), "--figures-dir", str(tmp_path / "figures")]
    places += ["--benchmarks", str(tmp_path / "benchmarks")]
    main(["report", "--case-dir", str(tmp_path / "cases" / "tube"), *places, "--out", str(path)])
    text = path.read_text()
    text = text[text.index("Deployment: beside the textbook scheme") :]
    for words in ("not done after 60 CPU s", "<th>error (%)</th>", "<td>43.21</td>", "not reached", "data:image/webp"):
        assert words in text, words


@pytest.mark.slow
def test_a_missing_figure_is_named(study, tmp_path, capsys):
    path = study(("tube", {}))
    (tmp_path / "figures" / "tube_area.svg").unlink()
    path.unlink()
    places = ["--study-dir", str(tmp_path / "study"), "--figures-dir", str(tmp_path / "figures")]
    with pytest.raises(SystemExit):
        main(["report", "--case-dir", str(tmp_path / "cases" / "tube"), *places, "--out", str(path)])
    assert "tube_area.svg" in capsys.readouterr().err and not path.exists()


@pytest.mark.parametrize(
    "body, where",
    [
        ('<img src="picture.png">', "img"),
        ('<script src="https://example.org/three.js"></script>', "script"),
        ('<a href="other.html">x</a>', "other.html"),
        ("<style>@import 'x.css';</style>", "x.css"),
        ("<style>p { background: url(tile.png) }</style>", "tile.png"),
        ('<p style="background: url(tile.png)">', "tile.png"),
    ],
)
def test_outside_references_are_found(body, where):
    found = outside_references(f"<html><head>{POLICY}</head><body>{body}</body></html>")
    assert len(found) == 1 and where in found[0]


def test_a_page_without_policy_is_refused():
    assert "policy" in outside_references("<html><body>text</body></html>")[0]
    page = f'<html>{POLICY}<body><a href="#top">up</a><img src="data:,"></body></html>'
    assert outside_references(page) == []


def test_console_messages_of_a_log():
    log = (
        '[1:1:1121/07:INFO:CONSOLE:1] "Uncaught ReferenceError: x", source: file:///a (1)\n'
        '[1:1:1121/07:INFO:CONSOLE(3)] "boom", source: file:///a (3)\n'
        '[1:1:1121/07:INFO:CONSOLE:0] "[.WebGL-0xf5]GL Driver Message (OpenGL, Performance, X, High): stall", source\n'
        "[1:1:1121/07:ERROR:dbus/bus.cc:405] Failed to connect to the bus\n"
    )
    messages = console_messages(log)
    assert len(messages) == 2 and "ReferenceError" in messages[0] and "boom" in messages[1]


@needs_chromium
@pytest.mark.parametrize("script", ["undefined_function()", "console.error('boom')", "fetch('data.json')"])
def test_a_page_with_a_failing_script_is_refused(tmp_path, script):
    policy = POLICY.replace("'none'\"", "'none'; script-src 'unsafe-inline'\"")
    (tmp_path / "page.html").write_text(f"<html>{policy}<body><script>{script}</script></body></html>")
    with pytest.raises(ComputationError, match="console"):
        check_report(tmp_path / "page.html")


def test_a_suite_of_compiled_tests_is_one_row(tmp_path):
    """CTest gives a test's name as its class; GoogleTest's parametrised names have slashes."""
    names = ("tests.verification.vci.Tube.Thick", "tests.verification.vci.Tube.Thin", "tests.unit.anatomy.Ends/A.Cut/0")
    cases = "".join(f'<testcase name="{name}" classname="{name}" time="0.5" status="run"/>' for name in names)
    (tmp_path / "junit.xml").write_text(f"<testsuite>{cases}</testsuite>")
    tubes, ends = evidence_rows(read_test_results([tmp_path / "junit.xml"]))
    assert (tubes["kind"], tubes["part"], tubes["tests"], tubes["passed"]) == ("verification", "vci", "Tube", 2)
    assert (ends["kind"], ends["part"], ends["passed"]) == ("unit", "anatomy", 1)


def test_evidence_counts_each_outcome(tmp_path):
    (tmp_path / "junit.xml").write_text(JUNIT)
    first, second = evidence_rows(read_test_results([tmp_path / "junit.xml"]))
    assert (first["kind"], first["part"], first["passed"], first["skipped"]) == ("verification", "flow", 1, 1)
    assert (second["kind"], second["part"], second["failed"], second["reasons"]) == ("unit", "vci", 1, ["1 != 2"])


@pytest.mark.parametrize("text", ["<html></html>", "not xml"])
def test_what_is_no_test_result_is_refused(tmp_path, text):
    (tmp_path / "junit.xml").write_text(text)
    with pytest.raises(InputError):
        read_test_results([tmp_path / "junit.xml"])


def test_numbers_as_they_are_shown():
    assert signed(-0.02) == "−0.02" and signed(0.123, 1) == "+0.1" and signed(-0.001) == "0.00"
    assert signed_decimals(-0.00012345, 3) == "−0.00012" and signed_decimals(0.0123, 3) == "+0.012"
    assert (
        signed_decimals(1e-9, 3) == "0.000000"
        and signed_decimals(0.0, 3) == "0.000"
        and signed_decimals(None, 3) == "–"
    )
    assert (
        signed_significant(-0.00012345) == "−0.00012"
        and signed_significant(0.0) == "0.0"
        and signed_significant(12.34) == "+12"
    )
    assert (
        significant(0.0996) == "0.100"
        and significant(1.55) == "1.6"
        and significant(None) == signed_significant(None) == "–"
    )
    assert fixed(None) == "–" and fixed(98000, 0) == "98,000"
    assert json.dumps(fixed(1.005, 1)) == '"1.0"'
