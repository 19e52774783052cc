"""Where the tests look for built programs and public data."""

import places


def test_programs_are_in_the_named_folder(monkeypatch):
    monkeypatch.setenv("VCI_BUILD_DIR", "elsewhere")
    assert str(places.build_folder()) == "elsewhere"
    monkeypatch.delenv("VCI_BUILD_DIR")
    assert places.build_folder() == places.ROOT / "build"


def test_each_file_is_looked_for_in_each_folder(monkeypatch, tmp_path):
    monkeypatch.setattr(places, "ROOT", tmp_path / "repository")
    for folder, names in {"given": "a", "repository/data": "ab", "shared/data": "abc"}.items():
        (tmp_path / folder).mkdir(parents=True)
        for name in names:
            (tmp_path / folder / name).touch()
    monkeypatch.setenv("VCI_DATA_DIR", str(tmp_path / "given"))
    found = {name: places.public_data(name) for name in "abcd"}
    assert found == {
        "a": tmp_path / "given" / "a",
        "b": tmp_path / "repository" / "data" / "b",
        "c": tmp_path / "shared" / "data" / "c",
        "d": None,
    }
