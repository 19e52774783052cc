"""The verdict: its sentences hold for any cohort, of one patient or many, with or without a truth."""

import re

import pytest

from reports.measuring.device_readouts import LARGEST_MALAPPOSITION_MM, LEAST_EXPANSION
from reports.page.verdict import warnings
from reports.page.verdict.lines import verdict
from reports.page.verdict.warnings import MOST_NAMED
from reports.study.agreement import agreement_table
from reports.study.nearer import nearer_table
from reports.whatif.tables import records

TITLES = ["Patients", "FFR past the lesion", "VCI or radius correction", "Warnings", "What this cannot tell"]


def state(ffr, area=7.0, curvature=0.1, error=0.001):
    """A state of metrics.json; without a flow if ffr is None."""
    return {
        "ffr": None if ffr is None else {"distal": ffr, "at_wire": ffr, "error_estimate": error},
        "area": {"mean_mm2": area, "minimum_mm2": area - 1.0},
        "curvature": {"mean_per_mm": curvature},
    }


def patient(name, states, kind="synthetic", measured=None, expansion=0.8, gap=0.1, tolerance_met=True, modified=()):
    """The context of a case, as far as the verdict reads it."""
    flow = {
        one: {"error": entry["ffr"]["error_estimate"], "solution": {"tolerance_met": tolerance_met}}
        for one, entry in states.items()
        if entry["ffr"]
    }
    return {
        "name": name,
        "id": f"case-{name}",
        "metrics": {"case": name, "kind": kind, "states": states, "measured": measured},
        "flow": flow,
        "modified": list(modified),
        "deployment": {"stents": [{"expansion_index": expansion}], "maximal_malapposition_mm": gap},
        "stent_edges": [{"largest_stretch": 1.2, "beyond_limit": False}],
    }


def with_truth(name, k, truth="reference", before=0.7, after=0.925, vci=-0.005, rc=-0.0045, **options):
    """A patient with a truth. VCI is nearer to its areas and curvature; the area errors of both methods grow with k.

    before, after: FFR before PCI and in the truth; vci, rc: errors of the predicted FFR.
    """
    states = {
        "pre": state(before, 4.0, 0.12),
        "vci": state(after + vci, 7.0 + 0.1 * k, 0.11),
        "rc": state(after + rc, 7.0 + 0.2 * k, 0.12),
        truth: state(after, 7.0, 0.10),
    }
    return patient(name, states, **options)


def lines_of(*contexts, failed=()):
    """{title: line} of the verdict on these patients, with the study's own tables."""
    documents = [context["metrics"] for context in contexts]
    tables = [records(table(documents)) for table in (agreement_table, nearer_table)]
    found = verdict(contexts, *tables, failed)
    assert [line["title"] for line in found] == [title for title in TITLES if title in [one["title"] for one in found]]
    return {line["title"]: line for line in found}


def texts_of(*contexts, failed=()):
    return {title: line["text"] for title, line in lines_of(*contexts, failed=failed).items()}


def test_nine_patients_of_whom_areas_decide_and_ffr_does_not():
    patients = (with_truth(f"p{k}", k, before=0.65 + 0.01 * k, after=0.9 + 0.005 * k) for k in range(1, 10))
    text = texts_of(*patients)
    assert (
        text["Patients"] == "9 patients, all synthetic. All have FFR below 0.80 before PCI, the criterion of inclusion."
    )
    assert text["FFR past the lesion"].startswith(
        "0.70 ± 0.03 before PCI, 0.92 ± 0.01 after virtual PCI (VCI), 0.92 ± 0.01 in the finite-element reference."
    )
    assert (
        "VCI minus the reference: −0.0050 ± 0.0000; the flow's own error is up to 0.0010."
        in text["FFR past the lesion"]
    )
    assert text["VCI or radius correction"] == (
        "Mean errors against the reference, VCI's first. FFR does not decide (0.0050 and 0.0045): the flow's own"
        " error is up to 0.0010, no less than their difference. VCI is nearer in mean CSA (0.50 and 1.0 mm²,"
        " p = 0.0039), smallest CSA (0.50 and 1.0 mm², p = 0.0039) and mean curvature (0.010 and 0.020 /mm,"
        " p = 0.0039)."
    )
    assert text["Warnings"].startswith("None: each FFR is within the flow's tolerance")
    assert "shares lumen, plan and flow solver" in text["What this cannot tell"]
    assert "Nothing was compared with images" in text["What this cannot tell"]
    assert sum(len(line.split()) for line in text.values()) < 200, "the summary is read in a minute"


@pytest.mark.parametrize(
    "rc, error, words",
    [
        (-0.01, 0.001, "VCI is nearer in FFR (0.0050 and 0.010, p = 0.031); the flow's own error is up to 0.0010."),
        (-0.001, 0.001, "Radius correction is nearer in FFR (0.0050 and 0.0010, p = 0.031); the flow's own"),
        (-0.01, 0.006, "FFR does not decide (0.0050 and 0.010): the flow's own error is up to 0.0060, no"),
        (-0.01, None, "FFR does not decide (0.0050 and 0.010): the flow's own error is not known."),
    ],
)
def test_ffr_decides_beyond_the_flows_error_only(rc, error, words):
    patients = [with_truth(f"p{k}", k, rc=rc) for k in range(6)]
    for one in patients:
        for entry in one["metrics"]["states"].values():
            entry["ffr"]["error_estimate"] = error
    text = texts_of(*patients)
    assert words in text["VCI or radius correction"]
    known = "not known" if error is None else f"up to {error:.4f}"
    assert f"the flow's own error is {known}." in text["FFR past the lesion"]


def test_methods_that_cannot_be_told_apart_and_one_that_loses():
    """Each method is nearer in area in half of the patients. Radius correction is nearer in curvature."""
    patients = [with_truth(f"p{k}", k) for k in range(1, 7)]
    for k, one in enumerate(patients):
        states = one["metrics"]["states"]
        areas = (7.3, 7.2) if k % 2 else (7.2, 7.3)
        states["vci"], states["rc"] = state(0.92, areas[0], 0.14), state(0.921, areas[1], 0.11)
    text = texts_of(*patients)["VCI or radius correction"]
    assert "Radius correction is nearer in mean curvature (0.040 and 0.010 /mm, p = 0.031)." in text
    assert "No difference is shown in mean CSA (0.25 and 0.25 mm², p = 1.0) and smallest CSA" in text
    assert "VCI is nearer" not in text


def test_one_patient_decides_nothing():
    text = texts_of(with_truth("only", 1))
    assert text["Patients"] == "1 patient, synthetic. FFR before PCI is 0.70; below 0.80 is the criterion of inclusion."
    assert text["FFR past the lesion"].startswith(
        "0.70 before PCI, 0.92 after virtual PCI (VCI), 0.93 in the finite-element"
    )
    assert "−0.0050; the flow's" in text["FFR past the lesion"], "no standard deviation of one value"
    assert "1 patient is too few for a test, which needs 6; VCI's error is smaller in mean CSA" in (
        text["VCI or radius correction"]
    )
    assert "p = " not in text["VCI or radius correction"] and "nearer" not in text["VCI or radius correction"]


def test_too_few_patients_show_whose_error_is_smaller_in_what():
    patients = [with_truth(f"p{k}", k) for k in (1, 2)]
    for one in patients:
        one["metrics"]["states"]["rc"]["curvature"]["mean_per_mm"] = 0.101
    text = texts_of(*patients)["VCI or radius correction"]
    assert text.endswith(
        "2 patients are too few for a test, which needs 6; VCI's error is smaller in mean CSA (0.15 and 0.30 mm²) and"
        " smallest CSA (0.15 and 0.30 mm²); radius correction's error is smaller in mean curvature (0.010 and 0.0010"
        " /mm)."
    )


def test_without_any_truth_the_prediction_is_untested():
    own = patient("own", {"pre": state(0.7), "vci": state(0.9)}, kind="surface")
    text = texts_of(own)
    assert text["Patients"].startswith("1 patient, with a given lumen.")
    assert text["FFR past the lesion"] == (
        "0.70 before PCI, 0.90 after virtual PCI (VCI). No FFR after PCI is known to compare with."
    )
    assert "VCI or radius correction" not in text
    assert text["What this cannot tell"] == "Nothing is known after PCI, so the prediction is untested."


def test_real_patients_with_a_lumen_after_pci_and_a_wire():
    wire = {"ffr_pre": 0.72, "ffr_post": 0.9}
    first = with_truth("a", 1, truth="post", kind="surface", measured=wire)
    second = with_truth("b", 2, truth="post", kind="surface")
    second["metrics"]["states"]["post"]["ffr"] = None  # compared by areas only
    text = texts_of(first, second)
    assert text["Patients"].startswith("2 patients, all with a given lumen. All have FFR below 0.80")
    assert "0.93 in the lumen after the real PCI (1 of 2 patients)." in text["FFR past the lesion"]
    assert "by pressure wire before PCI: −0.020 (n = 1)." in text["FFR past the lesion"]
    assert "by pressure wire after virtual PCI: +0.020 (n = 1)." in text["FFR past the lesion"]
    assert "Mean errors against the lumen after the real PCI" in text["VCI or radius correction"]
    assert text["What this cannot tell"] == "Errors against a lumen after real PCI hold those of both images."


def test_a_wire_alone_is_no_lumen_but_something_known():
    wire = {"ffr_pre": None, "ffr_post": 0.88}
    text = texts_of(patient("w", {"pre": state(0.7), "vci": state(0.9)}, kind="surface", measured=wire))
    assert "No FFR after PCI is known" not in text["FFR past the lesion"]
    assert "after virtual PCI: +0.020 (n = 1)." in text["FFR past the lesion"] and "VCI or radius" not in text
    assert "What this cannot tell" not in text


def test_lumens_after_real_pci_without_any_flow():
    """Only areas are compared, so neither line may speak of a known FFR after PCI."""
    one = with_truth("a", 1, truth="post", kind="surface")
    one["metrics"]["states"]["post"]["ffr"] = None
    text = texts_of(one)
    assert text["FFR past the lesion"].endswith("No FFR after PCI is known to compare with.")
    assert "FFR" not in text["VCI or radius correction"] and "mean CSA" in text["VCI or radius correction"]


def test_patients_of_both_kinds_partly_included_and_failed_ones():
    mild, own = with_truth("mild", 1, before=0.85), patient(
        "own", {"pre": state(0.7), "vci": state(0.9)}, kind="surface"
    )
    failed = [{"case": "lost"}, {"case": "lost"}, {"case": "own"}]
    text = texts_of(with_truth("a", 1), mild, own, failed=failed)
    assert text["Patients"] == (
        "3 patients, 2 synthetic and 1 with a given lumen. 2 have FFR below 0.80 before PCI, the criterion of"
        " inclusion. The numbers are of these 2. 1 more case failed and has no result."
    )
    assert "(1 of 2 patients)" in text["FFR past the lesion"], "the mild narrowing is not mixed with the included"
    assert "In 1 patient nothing is known after PCI" in text["What this cannot tell"]


def test_numbers_of_patients_that_are_not_included_are_said_to_be():
    mild, own = with_truth("mild", 1, before=0.85), patient("own", {"pre": state(0.7), "vci": state(0.9)})
    assert "The numbers are of those not included." in texts_of(mild, own)["Patients"]
    text = texts_of(mild, with_truth("milder", 2, before=0.9))
    assert "None has FFR below 0.80 before PCI, the criterion of inclusion. The numbers are of those not included." in (
        text["Patients"]
    )
    assert text["FFR past the lesion"].startswith("0.88 ± 0.04 before PCI")


def test_an_ffr_before_pci_that_is_not_known_is_said():
    unknown = patient("u", {"pre": state(None), "vci": state(None)}, kind="surface")
    text = texts_of(with_truth("a", 1), unknown)
    assert "1 have FFR" not in text["Patients"] and "1 has FFR below 0.80 before PCI" in text["Patients"]
    assert "It is not known in 1." in text["Patients"]
    text = texts_of(unknown)
    assert "FFR before PCI is not known; below 0.80 is" in text["Patients"]
    assert text["FFR past the lesion"] == "No FFR was computed after PCI."


def test_what_puts_a_result_in_doubt_is_named_with_its_patients():
    low = with_truth("low", 1, vci=-0.105, expansion=0.57, gap=0.46, tolerance_met=False, modified=["pre"])
    low["flow"]["pre"]["error"] = None
    low["stent_edges"] += [{"largest_stretch": stretch, "beyond_limit": True} for stretch in (1.52, 1.61)]
    folded = "the wall is folded: 7 pairs of its triangles cross, first at (2.8, 30.3, 1.8) mm; do not trust areas"
    low["deployment"]["warnings"] = ["malapposition: a stent stands 0.46 mm off the wall", folded]
    edge = with_truth("edge", 1, after=0.905, expansion=LEAST_EXPANSION, gap=LARGEST_MALAPPOSITION_MM)
    line = lines_of(low, edge)["Warnings"]
    found = {one["what"]: {case["name"]: case["detail"] for case in one["cases"]} for one in line["warnings"]}
    assert line["text"] == "" and found == {
        "FFR not known to be within the flow's tolerance": {"low": "4 states, at most ± 0.0010 where known"},
        "flow with artificial viscosity": {"low": "before"},
        "wall folded by the deployment": {"low": "7 pairs of its triangles cross"},
        "expansion index below 0.6": {"low": "0.57"},
        "malapposition beyond 0.4 mm": {"low": "0.46 mm"},
        "wall stretched beyond 1.5 at a stent's edge": {"low": "1.61"},
        "FFR after PCI below 0.90": {"low": "VCI 0.82, reference 0.93"},
    }


def test_few_states_are_named_and_many_are_counted():
    case = with_truth("c", 1, tolerance_met=False, modified=["pre", "vci"])
    case["flow"] = {state: case["flow"][state] for state in ("pre", "vci")}
    case["flow"]["pre"]["error"] = None
    assert warnings.tolerance_detail(case) == "before ± unknown, VCI ± 0.0010"
    assert warnings.viscosity_detail(case) == "before, VCI"
    case["modified"].append("rc")
    assert warnings.viscosity_detail(case) == "3 states"
    many = with_truth("m", 1, tolerance_met=False)
    assert warnings.tolerance_detail(many) == "4 states, at most ± 0.0010"
    for row in many["flow"].values():
        row["error"] = None
    assert warnings.tolerance_detail(many) == "4 states, error unknown"


def test_a_low_ffr_after_pci_counts_too_where_the_prediction_missed_it():
    missed = with_truth("m", 1)
    missed["metrics"]["states"]["reference"] = state(0.88)
    (warning,) = lines_of(missed)["Warnings"]["warnings"]
    assert warning["cases"][0]["detail"] == "VCI 0.92, reference 0.88"
    missed["metrics"]["states"]["vci"] = state(0.881)
    (warning,) = lines_of(missed)["Warnings"]["warnings"]
    assert warning["cases"][0]["detail"] == "0.88"


def test_a_long_list_of_patients_is_cut_and_counted():
    (warning,) = lines_of(*(with_truth(f"p{k}", 1, gap=0.5) for k in range(MOST_NAMED + 3)))["Warnings"]["warnings"]
    assert len(warning["cases"]) == MOST_NAMED and warning["more"] == 3


def test_what_was_not_deployed_or_has_no_stent_is_not_warned_of():
    balloon, none = with_truth("balloon", 1), with_truth("none", 1)
    balloon["deployment"] = {"stents": [{"expansion_index": None}], "maximal_malapposition_mm": None}
    none["deployment"], none["stent_edges"] = None, []
    assert lines_of(balloon, none)["Warnings"]["warnings"] == []


def test_the_limits_are_those_of_the_engine(repo_root):
    header = (repo_root / "vci" / "results" / "readouts.hpp").read_text()
    limits = dict(re.findall(r"double (least_expansion|largest_malapposition) = ([0-9.]+);", header))
    assert {name: float(value) for name, value in limits.items()} == {
        "least_expansion": LEAST_EXPANSION,
        "largest_malapposition": LARGEST_MALAPPOSITION_MM,
    }
