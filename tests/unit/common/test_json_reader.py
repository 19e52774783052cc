"""The one reader of JSON: what it refuses, with which remedy, and the plan that is read by it."""

import json

import pytest

from common.documents import json_reader, plan_reader
from common.errors import InputError

REFUSED = {
    "cut.json": ('{"a": [1, 2', "not a JSON file"),
    "list.json": ("[1, 2]", "not a group of keys"),
    "nan.json": ('{"a": {"b": NaN}}', "(?s)not finite.*key a.b"),
    "infinite.json": ('{"a": [0, 1e999]}', "(?s)not finite.*key a.2."),
    "long.json": ('{"a": 1' + 5000 * "0" + "}", "not a JSON file"),
    "deep.json": ('{"a": ' + 100000 * "[" + 100000 * "]" + "}", "not a JSON file"),
}


def step(device="des", **more):
    use = {"device": device, "branch": "main", "centre_s_mm": 9.0, "pressure_bar": 11, **more}
    return {"name": "stent", "action": "stent", "devices": [use]}


def plan(*steps):
    return {"schema": "vci-scene-1", "devices": {"des": {"kind": "stent", "length_mm": 18}}, "procedure": list(steps)}


@pytest.mark.parametrize("name", REFUSED)
def test_what_is_no_document_is_refused(tmp_path, name):
    text, message = REFUSED[name]
    (tmp_path / name).write_text(text)
    with pytest.raises(InputError, match=message) as caught:
        json_reader.read(tmp_path / name, "kind")
    assert name in caught.value.where
    with pytest.raises(InputError) as caught:
        json_reader.read(tmp_path / name, "kind", "write it anew")
    assert caught.value.remedy == "write it anew"


def test_a_file_that_is_not_there_is_named_with_its_kind(tmp_path):
    with pytest.raises(InputError, match="no such file") as caught:
        json_reader.read(tmp_path / "gone.json", "plan.json")
    assert caught.value.remedy == "give a file of the kind plan.json"


def test_a_number_is_found_however_deep_it_lies():
    """Newer Pythons parse files that are nested deeper than their functions may call each other."""
    value = float("nan")
    for _ in range(3000):
        value = [value]
    with pytest.raises(InputError, match="not finite"):
        json_reader.Document("a.json", {"a": value}).check_finite()


def test_values_count_in_the_order_of_the_file():
    document = json_reader.Document("a.json", {"a": {"b": 1, "c": [2, 3]}, "d": 4})
    places = [(), ("a",), ("a", "b"), ("a", "c"), ("a", "c", 0), ("a", "c", 1), ("d",)]
    assert [document.line(place) for place in places] == list(range(7))


def test_a_sound_plan_is_read_as_it_is(tmp_path):
    document = plan(step(), step()) | {"other": [1, 2.5]}
    (tmp_path / "plan.json").write_text(json.dumps(document))
    assert plan_reader.read(tmp_path / "plan.json") == document


@pytest.mark.parametrize(
    "document, message",
    [
        ({"schema": "vci-metrics-1"}, "(?s)not a plan.*key schema.*vci-metrics-1.*anatomy plan"),
        (plan(), "(?s)key procedure.*at least 1"),
        (plan(step(), step("none")), "(?s)does not define.*key procedure.2..devices.1..device.*none.*des"),
        (plan(step(centre_s_mm="9")), "(?s)key procedure.1..devices.1..centre_s_mm"),
        (plan(step()) | {"segment": {"branch": "main"}}, "(?s)key segment.*s_start_mm is missing"),
    ],
)
def test_what_is_no_plan_is_refused(tmp_path, document, message):
    (tmp_path / "plan.json").write_text(json.dumps(document))
    with pytest.raises(InputError, match=message):
        plan_reader.read(tmp_path / "plan.json")
