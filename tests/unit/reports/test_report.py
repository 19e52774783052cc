"""The report: the content of its pages, no links to other places, and nothing left of an earlier report."""

import base64
import json
import re
import shutil

import pytest

from common.errors import InputError
from reports.__main__ import main
from reports.page.benchmarks import TITLES
from reports.page.check import check_report, read_pages, run_browser
from reports.page.digits import fixed, fixed_decimals, signed, signed_decimals, signed_significant, significant
from reports.page.evidence import evidence_rows, read_test_results
from reports.page.folder import report_folder
from reports.page.source_map import read_source_map

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


class Report:
    """A report below the folder `root`, made from the case folders `dirs`."""

    def __init__(self, root, dirs):
        self.folder, self.index_file = root / "report", root / "report" / "index.html"
        places = ["--study-dir", str(root / "study"), "--figures-dir", str(root / "figures")]
        self.command = ["report", "--case-dir", *dirs, *places]

    def make(self, *options):
        """Makes the report, with further options of `reports report`. Returns itself."""
        main([*self.command, *options, "--out", str(self.folder)])
        return self

    @property
    def index(self):
        return self.index_file.read_text()

    def case(self, name):
        return (self.folder / "cases" / f"{name}.html").read_text()

    def files(self):
        """{name below the folder: bytes} of all files."""
        files = [path for path in self.folder.rglob("*") if path.is_file()]
        return {str(path.relative_to(self.folder)): path.read_bytes() for path in files}


@pytest.fixture
def study(make_case, add_arm, tmp_path):
    """study(*cases) makes all tables and figures and returns the Report. A case is (name, options of make_case)."""

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
        tables = ["--stations", str(tmp_path / "study" / "differences_stations.csv")]
        tables += ["--out", str(tmp_path / "study" / "differences.csv")]
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
        options = [*(["--junit", *map(str, junit)] if junit else []), "--cohort", "quick"]
        report = Report(tmp_path, dirs).make(*options)
        first = report.files()
        assert report.make(*options).files() == first, "the same bits"
        return report

    return make


@pytest.mark.slow
def test_report_of_a_case_with_and_one_without_reference(study, tmp_path):
    (tmp_path / "junit.xml").write_text(JUNIT)
    report = study(("tube", {}), ("own", {"states": ("pre", "vci")}), junit=[tmp_path / "junit.xml"])
    index, tube, own = report.index, report.case("tube"), report.case("own")
    for words in (
        "error of the <b>method</b> alone",
        "test_poiseuille",
        "its prediction is untested",
        "Along the stent: Diff<sup>A</sup> and Diff<sup>C</sup>",
        "Case by case: where the two methods part",
    ):
        assert words in index, words
    for words in (
        "<li>stub left closed: at (1, 2, 3)</li>",
        "elements 0.31 %",
        "slice spacing mm 1.0 instead of 0.75.",
        '<td class="text">balloon-extraction</td>',
        "Minimal stent area 7.30 mm²; smallest lumen within the stent 7.05 mm²",
        "<li>stent: opened beyond its maximal diameter</li>",
    ):
        assert words in tube, words
    assert index.count('class="viewer"') == 0 and tube.count('class="viewer"') == own.count('class="viewer"') == 1
    for words in ("49.8 % only", "stub left closed"):
        assert (index.count(words), tube.count(words), own.count(words)) == (2, 1, 1), words
    if shutil.which("chromium"):
        check_report(report.index_file, tmp_path / "shots")
        assert all((tmp_path / "shots" / f"{page}.png").stat().st_size > 20000 for page in ("index", "tube", "own"))
        page, _ = run_browser(report.folder / "cases" / "tube.html", "--dump-dom")
        assert page.count("<canvas") == 1 and 'class="stage live"' in page


@pytest.mark.slow
def test_each_case_has_a_page_between_its_neighbours(study):
    report = study(*((name, {"states": ("pre", "vci")}) for name in ("one", "two", "three")))
    assert set(read_pages(report.index_file)) == {
        report.index_file,
        report.folder / "benchmarks.html",
        *(report.folder / "cases" / f"{name}.html" for name in ("one", "two", "three")),
    }, "the index leads to every page, and each page passes"
    two = report.case("two")
    assert two.count('<a rel="prev" href="../cases/one.html">') == two.count('href="../cases/three.html">three →') == 2
    assert 'rel="prev"' not in report.case("one") and 'rel="next"' not in report.case("three")
    assert 'href="../index.html#patients">All patients' in two
    assert report.index.count("assets/three.min.js") == 0 and two.count('src="../assets/three.min.js"') == 1
    assert sum("three.min.js" in name for name in report.files()) == 1
    assert 'id="case-two"' in two and 'id="case-one"' not in two


@pytest.mark.slow
def test_an_earlier_report_leaves_nothing_behind(study, tmp_path):
    report = study(("tube", {}), ("own", {"states": ("pre", "vci")}))
    (report.folder / "report.json").write_text("{}")
    of_tube = [str(tmp_path / "cases" / "tube")]
    main(
        ["patients", "--metrics", f"{of_tube[0]}/metrics.json", "--configs", str(tmp_path / "configs" / "tube.yaml")]
        + ["--inclusion", str(tmp_path / "study" / "inclusion.csv"), "--figures-dir", str(tmp_path / "figures")]
        + ["--out", str(tmp_path / "study" / "patients.csv")]
    )
    main(["contrast", "--metrics", f"{of_tube[0]}/metrics.json", "--out", str(tmp_path / "study" / "contrast.csv")])
    files = Report(tmp_path, of_tube).make().files()
    assert "cases/tube.html" in files and files["report.json"] == b"{}", "what others write there stays"
    assert not [name for name in files if "own" in name or name.startswith(".")]


@pytest.mark.slow
def test_report_with_ct_keeps_four_errors_apart_and_shows_the_warnings(study):
    message = "main 18.0-21.0 mm: contrast on the axis falls to 0.41"
    warning = {"code": "occluded_by_voxels", "branch": "main", "message": message}
    states = ("pre", "vci", "rc", "reference", "ct", "ct_vci", "ct_rc")
    report = study(("tube", {"states": states, "warnings": [warning]}), ("other", {"states": states, "change": 0.02}))
    text, tube, other = report.index, report.case("tube"), report.case("other")
    for words in ("Four errors are kept apart", "All together (clinical)", "CT of the reference − reference"):
        assert words in text, words
    assert text.count(message) == tube.count(message) == 2, "two images: each with its case and among the limits"
    assert other.count("no warning.") == 2 and "no warning." not in tube
    clinical = next(row for row in text.split("<tr>") if "VCI from CT − CT" in row and "Mean CSA" in row)
    assert "−5.22 to +2.12" in clinical
    assert text.count("−5.22 to +2.12") == 1
    assert (
        '<option value="ct">' in tube and '<option value="ct_vci"' not in tube
    ), "too like the others in three dimensions"
    if shutil.which("chromium"):
        check_report(report.index_file)


@pytest.mark.slow
def test_the_figures_of_the_source_lead_to_their_places(study, tmp_path):
    """With the pictures that rules of their own draw, only other cases, a benchmark and the stent alone are missing."""
    report = study(("tube", {"states": ("pre", "vci", "rc", "reference", "ct", "ct_vci", "ct_rc")}))
    table = report.index.split('id="source-map"')[1]
    assert "CT slices: not in this run, needs a patient with a simulated CT" in table and "#ct-figure" not in table
    for name in ("tube_ct", "tube_procedure"):
        (tmp_path / "figures" / f"{name}.png").write_bytes(base64.b64decode(PNG))
    table = report.make().index.split('id="source-map"')[1]
    places = [place for row in read_source_map() for place in row["places"]]
    assert "not in this run, needs a case with metrics.stent_alone" in table and "#stent-alone" not in table
    here = [place["section"] for place in places if place["page"] != "benchmarks" and not place["cases"]]
    here.remove("stent-alone")
    assert re.findall(r'href="[^"#]*#([^"]+)"', table.split("</table>")[0]) == here
    assert table.count("not in this run, needs ") == len(places) - len(here) == 5
    assert 'href="cases/tube.html#ct-figure">CT slices</a> (tube)' in table
    read_pages(report.index_file)  # each link has its target


@pytest.mark.slow
def test_both_segmentations_stand_on_the_page_and_who_is_not_included(study):
    states = ("pre", "vci", "rc", "reference", "ct", "ct_vci", "ct_rc")
    text = study(("tube", {"states": states}), ("mild", {"states": states, "change": -0.2}), arm=True).index
    assert "How the lumen is found in the image" in text and "with an error of up to 0.0030" in text
    assert "The statistics are of the 1 included patient:" in text
    assert re.search(r'Not included is <a href="cases/mild.html">mild</a> \(FFR before PCI 0\.[89]\d\)', text)
    assert text.count("<details><summary>The same for the patients that are not included") == 1
    table = text.split("How the lumen is found in the image")[1].split("</table>")[0]
    clinical = next(row for row in table.split("<tr>") if "<th>FFR</th>" in row)
    # FFR predicted minus FFR after PCI, both by the network, and the published difference beside it
    assert ">−0.040</td>" in clinical and "−0.02 ± 0.05" in clinical


@pytest.mark.slow
def test_warnings_of_the_flow_are_shown_with_case_and_state(study, tmp_path):
    report, folder = study(("tube", {})), tmp_path / "cases" / "tube"
    assert "Doubtful FFR" not in report.index
    file = folder / "flow" / "rc" / "ffr.json"
    message = "FFR at the probe distal depends on its place: it still rises by 0.0016 a mm"
    file.write_text(json.dumps(json.loads(file.read_text()) | {"warnings": [message]}))
    text, case = report.make().index, report.case("tube")
    assert f"<li><b>Radius correction</b>: {message}</li>" in case
    assert f'<a href="cases/tube.html">tube</a> (rc), {message}.' in text
    assert text.count(message) == case.count(message) == 1, "of this state alone"


@pytest.mark.slow
def test_report_without_any_reference_or_tests_says_so(study):
    text = study(("own", {"states": ("pre", "vci")})).index
    assert "No case of this run has a reference" in text
    assert "carries no evidence of verification" in text and "Diff<sup>A</sup>" not in text
    assert "along the stent, of each patient: not in this run, needs a lumen after PCI" in text


@pytest.mark.slow
@pytest.mark.parametrize("ffr, eps, above, stars", [(0.86, 0.0, 1, 0), (0.72, 0.004, 0, 2)])
def test_a_mild_narrowing_and_a_modified_flow_are_said(study, tmp_path, ffr, eps, above, stars):
    report, folder = study(("tube", {})), tmp_path / "cases" / "tube"
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
    text = report.make().index
    assert report.case("tube").count("above 0.80, where a narrowing is usually left alone") == above
    note = "* This FFR is of a flow with some artificial viscosity"
    assert text.count('<a href="cases/tube.html">*</a>') + text.count(note) == stars


@pytest.mark.slow
def test_benchmarks_that_were_run_are_shown(study, tmp_path):
    report = study(("tube", {}))
    text = (report.folder / "benchmarks.html").read_text()
    assert 'id="benchmark-' not in text and "snakemake -j2 flow_hard_cases" in text
    for name, table in (
        ("flow_hard_cases", "case,outcome,ffr,residual_n,reason,cpu_s\nsharp_bend,fine,0.5,1.23456e-9,,31\n"),
        ("another", "n,seconds\n20000,0.5\n"),
    ):
        (tmp_path / "benchmarks" / name).mkdir(parents=True)
        (tmp_path / "benchmarks" / name / "table.csv").write_text(table)
    (tmp_path / "benchmarks" / "another" / "pareto.png").write_bytes(base64.b64decode(PNG))
    report.make("--benchmarks", str(tmp_path / "benchmarks"))
    text = (report.folder / "benchmarks.html").read_text()
    assert report.folder / "benchmarks.html" in read_pages(report.index_file)
    for words in ("<th>residual (N)</th>", "<td>1.235e-09</td>", "<td>0.5</td>", "<th>20000</th>", "sharp bend"):
        assert words in text, words
    for words in ('<th class="text">outcome</th>', '<td class="text">fine</td>', "<th>FFR</th>", "<th>CPU (s)</th>"):
        assert words in text, words
    assert ">reason</th>" not in text  # a column without a value is left out
    assert text.index("Blood flow: hard cases</h2>") < text.index('id="benchmark-another"')
    assert 'src="figures/another_pareto.webp"' in text and 'href="data/another_table.csv"' in text
    assert "<code>snakemake -j2 results/benchmarks/flow_hard_cases/table.csv</code>" in text
    before = report.files()
    (tmp_path / "benchmarks" / "another" / "table.csv").write_text("")
    with pytest.raises(SystemExit):
        report.make("--benchmarks", str(tmp_path / "benchmarks"))
    assert report.files() == before, "what fails leaves the earlier report as it was"


def test_every_benchmark_has_its_title_and_every_title_its_benchmark(repo_root):
    files = sorted((repo_root / "workflow" / "rules").glob("*benchmarks.smk"))
    rules = "\n".join(file.read_text() for file in files)
    outputs = re.findall(r"\n    output:\n((?:        .*\n)+)", rules)
    shown = [re.findall(r'"results/benchmarks/(\w+)/[\w.]+\.(?:csv|png|svg)"', output) for output in outputs]
    assert len(shown) == len(re.findall(r"^rule (?!benchmarks:)", rules, re.M)) and all(shown)
    assert {name for names in shown for name in names} == set(TITLES)


@pytest.mark.slow
def test_both_tables_of_the_textbook_comparison_and_its_figure_are_shown(study, tmp_path):
    report, folder = study(("tube", {})), tmp_path / "benchmarks" / "deployment_baseline"
    folder.mkdir(parents=True)
    (folder / "baseline.csv").write_text(
        "case,scheme,outcome,reason\ncalcified,textbook,stopped,not done after 60 CPU s\n"
    )
    (folder / "levels.csv").write_text(
        "case,error_percent,textbook_edge_mm,times\ncalcified,3,1.0,43.21\n,1,not reached,\n"
    )
    (folder / "baseline.png").write_bytes(base64.b64decode(PNG))
    report.make("--benchmarks", str(tmp_path / "benchmarks"))
    text = (report.folder / "benchmarks.html").read_text()
    text = text[text.index("Deployment: beside the textbook scheme") :]
    for words in ("not done after 60 CPU s", "<th>error (%)</th>", "<td>43.21</td>", "not reached", "baseline.webp"):
        assert words in text, words


@pytest.mark.slow
def test_a_missing_figure_is_named(study, tmp_path, capsys):
    report = study(("tube", {}))
    (tmp_path / "figures" / "tube_area.svg").unlink()
    shutil.rmtree(report.folder)
    with pytest.raises(SystemExit):
        report.make()
    assert "tube_area.svg" in capsys.readouterr().err and not report.files()


def test_two_pictures_of_one_name_are_refused(tmp_path):
    for place in ("a", "b"):
        (tmp_path / place).mkdir()
        (tmp_path / place / "plan.png").write_bytes(base64.b64decode(PNG))
    with report_folder(tmp_path / "report") as folder:
        assert folder.picture(tmp_path / "a" / "plan.png") == folder.picture(tmp_path / "a" / "plan.png")
        with pytest.raises(InputError, match="two pictures have one name"):
            folder.picture(tmp_path / "b" / "plan.png")


def test_a_suite_of_compiled_tests_is_one_row(tmp_path):
    """CTest writes a test's full name as its class. GoogleTest's names of parametrised tests have slashes."""
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
    assert fixed_decimals(0.00042, 3) == "0.00042" and fixed_decimals(0.0123, 3) == "0.012"
    assert fixed_decimals(0.0, 3) == "0.000" and fixed_decimals(None, 3) == "–"
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
