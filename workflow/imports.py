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
    return _import_closure({main, *_parent_packages(main)}, [*_imported_modules(main, top_level_only=True), *modules])


def command_code(part, function):
    """Like `code`, for the command that the function `function` of the part's __main__ runs.

    The command's modules are those imported in this function, and in functions of __main__ that it calls. Raises
    ValueError if __main__ has no such function.
    """
    return code(part, *_function_imports(f"{part}.__main__", function))


def script_code(script, *folders):
    """Files behind a script of this repository, relative to it, sorted.

    These are the script, the modules that it imports, and all that these import. The script may import from its own
    folder, from `folders`, which it puts on its path, and from the repository.
    """
    folders_to_search, found, names, pending = (
        [pathlib.Path(script).parent, *map(pathlib.Path, folders)],
        set(),
        set(),
        [script],
    )
    while pending:
        file = str(pending.pop())
        if file in found:
            continue
        found.add(file)
        for name in _names_in_imports(_all_statements(ast.parse((ROOT / file).read_text())), ""):
            sibling = [place / f"{name}.py" for place in folders_to_search if (ROOT / place / f"{name}.py").is_file()]
            pending += sibling[:1]
            names |= {name} if not sibling and _module_file(name) else set()
    return sorted(found | set(_import_closure(set(), [*names])))


def flow_benchmark_code(script):
    """Files behind a script of tests/verification/flow that meshes and solves by command."""
    commands = [command_code("flow", f"{command}_command") for command in ("mesh", "solve")]
    own = script_code(f"tests/verification/flow/{script}.py", "tests/unit/flow", "tests/support")
    return sorted({*own, *(file for files in commands for file in files)})


def module_code(name):
    """Files behind `python3 -m <name>`, a module that is its own command.

    Example: module_code("vci.benchmarks.benchmark").
    """
    return _import_closure(set(), [name])


def _import_closure(found, pending):
    """Files of the modules `found`, of the modules named in `pending`, and of all modules that these import, sorted.

    Raises ValueError for a name in `pending` that is no module of this repository.
    """
    for name in pending:
        if _module_file(name) is None:
            raise ValueError(f"no module {name}")
    while pending:
        name = pending.pop()
        if name not in found:
            found.add(name)
            pending += _parent_packages(name)
            pending += _imported_modules(name, top_level_only=False)
    return sorted(str(_module_file(name).relative_to(ROOT)) for name in found)


def _parent_packages(name):
    """The packages that Python loads before the module: a.b.c -> a, a.b."""
    parts = name.split(".")
    return [package for k in range(1, len(parts)) if _module_file(package := ".".join(parts[:k])) is not None]


@functools.lru_cache(maxsize=None)
def _module_file(name):
    """File of a module of this repository, or None."""
    path = ROOT.joinpath(*name.split("."))
    for file in (path.with_suffix(".py"), path / "__init__.py"):
        if file.is_file():
            return file
    return None


@functools.lru_cache(maxsize=None)
def _imported_modules(name, top_level_only):
    """Names of this repository's modules that the module `name` imports."""
    file = _module_file(name)
    tree = ast.parse(file.read_text(), filename=str(file))
    nodes = tree.body if top_level_only else _all_statements(tree)
    package = name if file.name == "__init__.py" else name.rpartition(".")[0]
    return frozenset(module for module in _names_in_imports(nodes, package) if _module_file(module) is not None)


@functools.lru_cache(maxsize=None)
def _function_imports(name, function):
    """Names of this repository's modules imported in a function of the module `name` and in functions that it calls."""
    tree = ast.parse(_module_file(name).read_text())
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
            named |= _names_in_imports(nodes, name.rpartition(".")[0])
    return frozenset(module for module in named if _module_file(module) is not None)


def _all_statements(node):
    """All statements within an ast node. Expressions are skipped, to save time: they hold no imports."""
    for field in ("body", "orelse", "finalbody", "handlers", "cases"):
        inner = getattr(node, field, [])
        for statement in (
            inner if isinstance(inner, list) else []
        ):  # a lambda or conditional expression has no list here
            yield statement
            yield from _all_statements(statement)


def _names_in_imports(nodes, package):
    """Full names that the import statements among the nodes may mean. package: the package of their module."""
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
