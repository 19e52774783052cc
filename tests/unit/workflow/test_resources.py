"""What steps ask a cluster for: by the size of their inputs and by the attempt."""

from workflow.rules.resources import resources_by_size, fixed_resources


def asked(resources, attempt=1, **input):
    """(MB, minutes) as Snakemake asks for them."""
    return tuple(resources[name](None, input=input, attempt=attempt) for name in ("mem_mb", "runtime"))


def test_by_size(tmp_path):
    mesh = tmp_path / "mesh.msh"
    mesh.write_bytes(bytes(2_500_000))
    resources = resources_by_size((1000, 600), (5, 2), "mesh")
    assert asked(resources, mesh=str(mesh)) == (2500, 10)
    assert asked(resources, attempt=2, mesh=str(mesh)) == (5000, 20)
    assert asked(resources, mesh=str(tmp_path / "not made yet")) == (1000, 5)


def test_a_folder_counts_with_all_its_files(tmp_path):
    (tmp_path / "series").mkdir()
    for name in ("1.dcm", "series/2.dcm"):
        (tmp_path / name).write_bytes(bytes(1_000_000))
    assert asked(resources_by_size((0, 10), (0, 1), "volume"), volume=str(tmp_path)) == (20, 2)


def test_fixed():
    assert asked(fixed_resources(1500, 10), attempt=2) == (3000, 20)
