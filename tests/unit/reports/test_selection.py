"""The patients on one page, and who of them is included."""

import pytest

from reports.__main__ import main
from reports.selection.patients import inclusion_table, patients_table

CALCIUM = {"plaque": "fibrous", "calcium": {"arc_deg": 120, "length_mm": 8}}
CASES = {
    "a": {"patient": {}, "vessel": {"artery": "lad", "lesions": [CALCIUM, {"plaque": "lipid"}, {"plaque": "fibrous"}]}},
    "b": {"patient": {"territory": "rca"}},
    "c": {"patient": {}},
}


def document(case, before, vci, after=None, state="reference"):
    """A metrics.json with FFR of its states; None: no flow."""
    states = {"pre": before, "vci": vci} | ({state: after} if after else {})
    ffr = {name: {"ffr": {"distal": value} if value else None} for name, value in states.items()}
    lesion = {"branch": "main", "s_start_mm": 10.0, "s_end_mm": 22.5, "diameter_stenosis_percent": 61.0}
    lesion["reference_diameter_mm"] = 3.1
    use = {"kind": "stent", "nominal_diameter_mm": 3.0, "length_mm": 18, "pressure_bar": 12}
    procedure = [{"action": "stent", "devices": [use]}]
    about = {"case": case, "lesion": lesion if case == "a" else None, "procedure": procedure}
    return about | {"measured": None, "states": ffr}


@pytest.fixture
def documents():
    return [document("a", 0.799, 0.91, 0.89), document("b", 0.80, 0.95, 0.96, "post"), document("c", 0.60, 0.899)]


def test_the_patients_on_one_page(documents):
    table = patients_table(documents, CASES).set_index("case")
    assert table.loc["a", ["artery", "lesion_length_mm", "lesions"]].tolist() == ["lad", 12.5, 3]
    assert table.loc["a", "plaque"] == "fibrous, lipid" and table.loc["a", "calcium"] == "120 degrees over 8 mm"
    assert table.loc["b", "artery"] == "rca" and table.loc["b", "ffr_after"] == 0.96
    assert table["included"].tolist() == [True, False, True], "0.80 itself is not below it"
    assert table["low_after"].tolist() == [False, False, True], "of the prediction"
    assert table.loc["a", "procedure"] == "stent: 3.00x18 mm stent at 12 bar"


def test_each_case_is_counted_once_among_left_out_and_included(documents):
    documents.append(document("d", None, None))
    cases = CASES | {"d": {"patient": {}}}
    states = {one["case"]: list(one["states"]) for one in documents} | {"c": ["pre", "vci", "reference", "ct_vci"]}
    steps = inclusion_table(patients_table(documents, cases), states)
    assert steps["count"].tolist() == [4, 1, 1, 2, 2, 1, 1]
    assert steps["cases"].tolist() == ["a b c d", "d", "b", "a c", "a c", "c", "c"]
    with_failed = inclusion_table(patients_table(documents, cases), states, ["e"])
    assert with_failed["count"].tolist() == [5, 2, 1, 2, 2, 1, 1]
    assert with_failed["cases"].tolist()[1] == "d e"


def test_a_case_without_its_file_is_refused(make_case, tmp_path):
    folder = make_case("tube")
    metrics = folder / "metrics.json"
    main(["metrics", "--case", "tube", "--case-dir", str(folder), "--out", str(metrics)])
    (tmp_path / "other.yaml").write_text("kind: surface\n")
    places = ["--inclusion", str(tmp_path / "i.csv"), "--figures-dir", str(tmp_path), "--out", str(tmp_path / "p.csv")]
    with pytest.raises(SystemExit):
        main(["patients", "--metrics", str(metrics), "--configs", str(tmp_path / "other.yaml"), *places])
    assert not (tmp_path / "p.csv").exists()
