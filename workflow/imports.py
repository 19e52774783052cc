"""Which files of this repository a Python command depends on: a change re-runs exactly the rules that use it."""

import ast
import functools
import pathlib

ROOT = pathlib.Path(__file__).resolve().parent.parent


def code(part, *modules):
    """Files behind `python3 -m <part> <command>`, relative to the repository, sorted.

    modules: those that the command loads, e.g. code("reports", "reports.metrics"). The part's __main__ counts with
    what it imports at its top level; what it imports inside its functions belongs to other commands.
    """
    main = f"{part}.__main__"
    return _files({main, *_packages(main)}, [*_imported(main, top_level_only=True), *modules])


def module_code(name):
    """Files behind `python3 -m <name>`, a module that is its own command, e.g. module_code("vci.benchmark")."""
    return _files(set(), [name])


def _files(found, pending):
    """Files of the modules `found` and of all that `pending` names and what those import, sorted.

    Raises ValueError for a name in `pending` that is no module of this repository.
    """
    for name in pending:
        if _file(name) is None:
            raise ValueError(f"no module {name}")
    while pending:
        name = pending.pop()
        if name not in found:
            found.add(name)
            pending += _packages(name)
            pending += _imported(name, top_level_only=False)
    return sorted(str(_file(name).relative_to(ROOT)) for name in found)


def _packages(name):
    """The packages that Python loads before the module: a.b.c -> a, a.b."""
    parts = name.split(".")
    return [package for k in range(1, len(parts)) if _file(package := ".".join(parts[:k])) is not None]


def _file(name):
    """File of a module of this repository, or None."""
    path = ROOT.joinpath(*name.split("."))
    for file in (path.with_suffix(".py"), path / "__init__.py"):
        if file.is_file():
            return file
    return None


@functools.lru_cache(maxsize=None)
def _imported(name, top_level_only):
    """Names of this repository's modules that the module `name` imports."""
    file = _file(name)
    tree = ast.parse(file.read_text(), filename=str(file))
    nodes = tree.body if top_level_only else ast.walk(tree)
    package = name if file.name == "__init__.py" else name.rpartition(".")[0]
    found = set()
    for node in nodes:
        if isinstance(node, ast.Import):
            found |= {alias.name for alias in node.names}
        elif isinstance(node, ast.ImportFrom):
            parts = package.split(".")
            base = parts[: len(parts) - node.level + 1] if node.level else []
            source = ".".join(base + ([node.module] if node.module else []))
            found |= {source} | {f"{source}.{alias.name}" for alias in node.names}
    return frozenset(module for module in found if _file(module) is not None)
