"""The summary's templates: text that is always visible, links of warnings, intervals beside FFR, the machine."""

import html.parser

import pytest

from common.patient.states import PREDICTED_FROM_CT
from reports.figures.style import LABELS, SHORT_LABELS
from reports.page.build import environment
from reports.study.agreement import published_provenance, published_results

MACHINE = {"processor": "AMD EPYC", "cores": 2, "memory_gib": 23.5}
SECONDS = {"by": "all", "name": "procedure", "n": 2, "mean_s": 2.86, "sd_s": 0.3}
SECONDS |= {"published_mean_s": 24.92, "published_sd_s": 1.0}
MOST_OPEN_WORDS = 250  # words that are read in a minute


class OpenText(html.parser.HTMLParser):
    """Collects the words of a page that are visible while all <details> are closed."""

    def __init__(self):
        super().__init__()
        self.depth, self.in_label, self.words = 0, False, []

    def handle_starttag(self, tag, attrs):
        self.depth += tag == "details"
        self.in_label |= tag == "summary" and self.depth == 1

    def handle_endtag(self, tag):
        self.depth -= tag == "details"
        self.in_label &= tag != "summary"

    def handle_data(self, data):
        if not self.depth or self.in_label:
            self.words += data.split()


def flow_state(ffr):
    """A state of metrics.json."""
    flow = {"distal": ffr, "error_estimate": 0.001, "past_segment": ffr}
    return {"ffr": flow, "area": {"mean_mm2": 7.0, "minimum_mm2": 6.0}, "curvature": {"mean_per_mm": 0.1}}


def case(name, ranges):
    """A case's context, as far as the summary and the table of states read it."""
    metrics = {"states": {"pre": flow_state(0.71), "vci": flow_state(0.92)}, "lesion": None, "differences": {}}
    metrics |= {"segment": {"branch": "main", "margin_mm": 2.0}, "stations": {"used": 101, "count": 101}}
    steps = [{"brief": "stent: 3.00x15 mm stent at 14 bar"}]
    return {
        "name": name,
        "id": f"case-{name}",
        "metrics": metrics,
        "steps": steps,
        "modified": [],
        "ffr_ranges": ranges,
    }


def patient_row(name):
    """A row of patients.csv."""
    row = dict.fromkeys(("artery", "branch", "plaque", "calcium", "stenosis_percent", "lesion_length_mm"))
    row |= {"case": name, "reference_diameter_mm": 3.1, "procedure": "stent", "included": True, "low_after": False}
    return row | {"ffr_before": 0.71, "ffr_vci": 0.92, "ffr_after": 0.93}


def summary_page(ranges, verdict=(), software=None):
    """The summary of nine patients."""
    names = [f"p{k}" for k in range(9)]
    means = dict.fromkeys(("ffr", "area", "minimum", "curvature"), (0.7, 0.1)) | {"n": 9}
    return (
        environment()
        .get_template("summary.html.j2")
        .render(
            cases=[case(name, ranges) for name in names],
            patients=[patient_row(name) for name in names],
            summary={"means": {"included": {"pre": means, "vci": means}}},
            states_shown=["pre", "vci"],
            from_ct=PREDICTED_FROM_CT,
            labels=LABELS,
            short=SHORT_LABELS,
            cohort="nine",
            failed=(),
            verdict=verdict,
            seconds=[SECONDS],
            seconds_figure="data:,",
            published=published_results(),
            software=software,
            scatter="data:,",
            inclusion="data:,",
            low_mark="▼",
        )
    )


def test_tables_are_closed_and_few_words_stay_open():
    """The verdict's own words are counted in test_verdict."""
    page = OpenText()
    page.feed(summary_page({}))
    assert 30 < len(page.words) < MOST_OPEN_WORDS - 200
    assert "p0" not in page.words and "Seconds" in page.words


@pytest.mark.parametrize("template", ["summary", "states"])
def test_the_interval_stands_beside_each_ffr_that_has_one(template):
    def render(ranges):
        if template == "summary":
            return summary_page(ranges)
        page = environment().get_template("states.html.j2")
        return page.render(case=case("a", ranges), labels=LABELS, short=SHORT_LABELS)

    text = render({"pre": (0.66, 0.78), "vci": (0.9, 0.95)})
    assert "0.710<br><small>0.66–0.78</small></td>" in text and "0.920<br><small>0.90–0.95</small></td>" in text
    assert "below " in text and "the middle 95 % over what is not known exactly" in text
    text = render({"vci": (0.9, 0.95)})
    assert "<td>0.710</td>" in text and text.count("<small>") == (2 * 9 if template == "summary" else 1)
    assert "middle 95 %" not in render({})


def test_warnings_name_their_patients_and_link_them():
    cases = [{"name": "a<b", "id": "case-a", "detail": "0.46 mm"}, {"name": "c", "id": "case-c", "detail": "0.5 mm"}]
    groups = [
        {"what": "malapposition beyond 0.4 mm", "cases": cases, "more": 3},
        {"what": "FFR after PCI below 0.90", "cases": cases[1:], "more": 0},
    ]
    line = {"title": "Warnings", "text": "", "warnings": groups}
    text = " ".join(environment().get_template("verdict.html.j2").render(verdict=[line]).split())
    assert "Malapposition beyond 0.4 mm: <a" in text and "FFR after PCI below 0.90: <a" in text
    assert (
        "a&lt;b</a> (0.46 mm), <a" in text
        and "c</a> (0.5 mm) and 3 more.</li>" in text
        and "c</a> (0.5 mm).</li>" in text
    )


@pytest.mark.parametrize(
    "software, words",
    [
        ({"machine": MACHINE}, "This machine: AMD EPYC, 2 cores, 23.5 GiB of memory"),
        (
            {"machine": MACHINE | {"processor": "", "cores": 1, "memory_gib": None}},
            "not named by Linux, 1 core, memory not",
        ),
        ({"packages": {}}, "This machine: not recorded; <code>results/study/software.json</code>"),
        (None, "This machine: not recorded"),
    ],
)
def test_the_machines_stand_beside_the_seconds(software, words):
    text = " ".join(summary_page({}, software=software).split())
    assert words in text and "Seconds of the virtual procedure: 2.9 ± 0.3 here, 24.9 ± 1.0 published" in text
    assert "on a single processor" in text and "not recorded, since this package has no note of them" in text


def test_published_seconds_have_their_deviation_and_say_where_they_were_read():
    text = " ".join(summary_page({}).split())
    assert "<td>2.86 ± 0.30</td><td>24.92 ± 1.00</td>" in text
    for name, words in (("seconds.all", "of the whole procedure"), ("seconds.stage", "of stages and steps")):
        assert f"{words} are {published_provenance(name)}." in text
