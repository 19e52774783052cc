"""Which files of this repository a Python command depends on. A changed file re-runs only the rules that use it."""

import ast
import functools
import pathlib

ROOT = pathlib.Path(__file__).resolve().parent.parent


def code(part, *modules):
    """Files behind `python3 -m <part> <command>`, relative to the repository, sorted.

    modules: the modules that the command loads, e.g. code("reports", "reports.measuring.metrics"). Top-level imports of
    the part's __main__ belong to every command. Imports inside its functions belong to one command each.
    """
    main = f"{part}.__main__"
    return _files({main, *_packages(main)}, [*_imported(main, top_level_only=True), *modules])


def command_code(part, function):
    """As `code`, for the command that `function` in the part's __main__ runs.

    The modules are imported in this function, or in functions of __main__ that it calls. Raises
    ValueError if __main__ has no such function.
    """
    return code(part, *_imported_by(f"{part}.__main__", function))


def script_code(script, *folders):
    """Files behind a script of this repository, relative to it, sorted.

    These are the script, its imports from beside it or from `folders`, which it puts on its path, and all that these
    import.
    """
    places, found, names, pending = [pathlib.Path(script).parent, *map(pathlib.Path, folders)], set(), set(), [script]
    while pending:
        file = str(pending.pop())
        if file in found:
            continue
        found.add(file)
        for name in _named(_statements(ast.parse((ROOT / file).read_text())), ""):
            beside = [place / f"{name}.py" for place in places if (ROOT / place / f"{name}.py").is_file()]
            pending += beside[:1]
            names |= {name} if not beside and _file(name) else set()
    return sorted(found | set(_files(set(), [*names])))


def flow_benchmark_code(script):
    """Files behind a script of tests/verification/flow that meshes and solves by command."""
    commands = [command_code("flow", f"{command}_command") for command in ("mesh", "solve")]
    own = script_code(f"tests/verification/flow/{script}.py", "tests/unit/flow")
    return sorted({*own, *(file for files in commands for file in files)})


def module_code(name):
    """Files behind `python3 -m <name>`, a module that is its own command.

    Example: module_code("vci.benchmarks.benchmark").
    """
    return _files(set(), [name])


def _files(found, pending):
    """Files of the modules `found`, of the modules named in `pending`, and of all modules that these import, sorted.

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


@functools.lru_cache(maxsize=None)
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
    nodes = tree.body if top_level_only else _statements(tree)
    package = name if file.name == "__init__.py" else name.rpartition(".")[0]
    return frozenset(module for module in _named(nodes, package) if _file(module) is not None)


@functools.lru_cache(maxsize=None)
def _imported_by(name, function):
    """Names of this repository's modules imported in a function of the module `name` and in functions that it calls."""
    tree = ast.parse(_file(name).read_text())
    bodies = {node.name: node for node in tree.body if isinstance(node, ast.FunctionDef)}
    if function not in bodies:
        raise ValueError(f"no function {function} in {name}")
    reached, pending, named = set(), [function], set()
    while pending:
        function = pending.pop()
        if function not in reached:
            reached.add(function)
            nodes = list(ast.walk(bodies[function]))
            pending += [node.id for node in nodes if isinstance(node, ast.Name) and node.id in bodies]
            named |= _named(nodes, name.rpartition(".")[0])
    return frozenset(module for module in named if _file(module) is not None)


def _statements(node):
    """All statements within an ast node. Expressions are skipped: they hold no imports, and are most of the nodes."""
    for field in ("body", "orelse", "finalbody", "handlers", "cases"):
        inner = getattr(node, field, [])
        for one in inner if isinstance(inner, list) else []:  # in lambdas and conditional expressions it is no list
            yield one
            yield from _statements(one)


def _named(nodes, package):
    """Full names that the import statements among the nodes may mean, in a module of `package`."""
    found = set()
    for node in nodes:
        if isinstance(node, ast.Import):
            found |= {alias.name for alias in node.names}
        elif isinstance(node, ast.ImportFrom):
            parts = package.split(".")
            base = parts[: len(parts) - node.level + 1] if node.level else []
            source = ".".join(base + ([node.module] if node.module else []))
            found |= {source} | {f"{source}.{alias.name}" for alias in node.names}
    return found
