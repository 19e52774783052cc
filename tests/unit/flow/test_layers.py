"""Imports between the packages of flow/: each package may import only those before it in ORDER."""

import ast

ORDER = ("geometry", "physics", "inputs", "meshing", "discretisation", "solvers", "errors", "reduced")


def _imported(file):
    """Names of the packages of flow/ that a module imports from; "flow" for modules that lie in no package."""
    found = set()
    for node in ast.walk(ast.parse(file.read_text())):
        names = []
        if isinstance(node, ast.ImportFrom) and node.module:
            names = [f"{node.module}.{alias.name}" for alias in node.names]
        elif isinstance(node, ast.Import):
            names = [alias.name for alias in node.names]
        for parts in (name.split(".") for name in names):
            if parts[0] == "flow":
                found.add(parts[1] if parts[1] in ORDER else "flow")
    return found


def _against(folder):
    """[(module, package that it may not import)] of the imports in `folder` that break ORDER."""
    found = []
    for number, package in enumerate(ORDER):
        allowed = set(ORDER[: number + 1])
        for file in sorted((folder / package).rglob("*.py")):
            found += [(str(file.relative_to(folder)), name) for name in sorted(_imported(file) - allowed)]
    return found


def test_packages_import_one_way(repo_root):
    folder = repo_root / "flow"
    packages = {file.parent.name for file in folder.glob("*/__init__.py")}
    assert packages == set(ORDER)
    assert _against(folder) == []


def test_an_import_against_the_order_is_seen(tmp_path):
    for package in ORDER:
        (tmp_path / package).mkdir()
    (tmp_path / "solvers" / "one.py").write_text("from flow.reduced import network\nfrom flow.physics import ffr\n")
    (tmp_path / "errors" / "two.py").write_text("def late():\n    from flow import settings\n")
    assert _against(tmp_path) == [("solvers/one.py", "reduced"), ("errors/two.py", "flow")]
