"""Includes and imports go one way: each folder uses the folders that it is declared to build on, and no others."""

import ast
import pathlib
import re
import subprocess

import pytest

from common.documents import yaml_reader

ROOT = pathlib.Path(__file__).resolve().parents[2]
MODULES_PER_FOLDER = 12


def tracked(*patterns):
    """Files under version control, and those not yet added to it."""
    command = ["git", "ls-files", "--cached", "--others", "--exclude-standard", "--", *patterns]
    names = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, check=True).stdout.split("\n")
    return [pathlib.PurePath(name) for name in names if name and (ROOT / name).is_file()]


def declared_folders(text, part):
    """{folder: folders that it depends on} as a part's CMakeLists.txt declares them, in their order.

    Anatomy names its folders by anatomy_folder() and what they build on by LINKS; their headers' names start below src.
    """
    folders = {}
    for call in re.findall(rf"^source_folder\({part} ([^)]*)\)", text, re.MULTILINE):
        folder, *words = call.split()
        depends = words[words.index("DEPENDS") + 1 :] if "DEPENDS" in words else []
        ends = depends.index("LIBRARIES") if "LIBRARIES" in depends else len(depends)
        folders[f"{part}/{folder}"] = [f"{part}/{name}" for name in depends[:ends]]
    for call in re.findall(rf"^{part}_folder\(([^)]*)\)", text, re.MULTILINE):
        folder, *words = call.split()
        links = words[words.index("LINKS") + 1 :] if "LINKS" in words else []
        own = [word.removeprefix(f"{part}_") for word in links if word.startswith(f"{part}_")]
        folders[f"{part}/src/{folder}"] = [f"{part}/src/{name}" for name in own]
    return folders


def reachable(folders):
    """{folder: itself and all that it depends on, directly or by others}; a folder comes after those it depends on."""
    reached = {}
    for folder, depends in folders.items():
        for name in depends:
            assert name in reached, f"{folder} depends on {name}, which is not declared before it"
        reached[folder] = {folder}.union(*(reached[name] for name in depends))
    return reached


def foreign_includes(name, text, part, allowed):
    """Lines of a source that include a header of its part from a folder that is not allowed."""
    below = str(name).startswith(f"{part}/src/")  # headers are named from there, without the part
    wrong = []
    for line in re.finditer(r'^#include "([^"]+)"', text, re.MULTILINE):
        if line[1].startswith("common/") or not (below or line[1].startswith(f"{part}/")):
            continue
        folder = pathlib.PurePath(part, "src", line[1]).parent if below else pathlib.PurePath(line[1]).parent
        if str(folder) not in allowed:
            wrong.append(f"{name}: {line[0]}")
    return wrong


def cpp_parts():
    """Parts whose CMakeLists.txt declares folders."""
    files = ROOT.glob("*/CMakeLists.txt")
    return sorted(f.parent.name for f in files if declared_folders(f.read_text(), f.parent.name))


@pytest.mark.parametrize("part", cpp_parts())
def test_includes_go_one_way(part):
    """No folder of C++ sources includes a header of a folder that it does not depend on."""
    folders = reachable(declared_folders((ROOT / part / "CMakeLists.txt").read_text(), part))
    sources = tracked(f"{part}/*.cpp", f"{part}/*.hpp")
    wrong = [f"{s}: its folder is not declared" for s in sources if str(s.parent) not in {*folders, part}]
    for source in sources:
        allowed = folders.get(str(source.parent), {*folders, part})
        wrong += foreign_includes(source, (ROOT / source).read_text(), part, allowed)
    assert sources and not wrong, "\n".join(wrong)


@pytest.mark.parametrize("part", cpp_parts())
def test_folders_are_small_and_explained(part):
    """A folder holds a dozen modules at most, and a README of a few lines says which."""
    for folder in declared_folders((ROOT / part / "CMakeLists.txt").read_text(), part):
        modules = {s.stem for s in tracked(f"{folder}/*.cpp", f"{folder}/*.hpp") if str(s.parent) == folder}
        assert 0 < len(modules) <= MODULES_PER_FOLDER, f"{folder}: {len(modules)} modules"
        lines = (ROOT / folder / "README.md").read_text().strip().splitlines()
        assert len(lines) >= 2, f"{folder}/README.md says what the folder holds and what it may include"


def test_an_include_against_the_order_is_found():
    """The check sees a header of a folder above, and lets one of a folder below pass."""
    text = "source_folder(vci low)\nsource_folder(vci high DEPENDS low LIBRARIES fcl)\n"
    folders = reachable(declared_folders(text, "vci"))
    assert foreign_includes("x", '#include "vci/high/a.hpp"\n', "vci", folders["vci/low"])
    assert not foreign_includes("x", '#include "vci/low/a.hpp"\n', "vci", folders["vci/high"])
    text = "anatomy_folder(low\n  SOURCES a.cpp)\nanatomy_folder(high\n  SOURCES b.cpp\n  LINKS anatomy_low ${VTK})\n"
    folders = reachable(declared_folders(text, "anatomy"))
    below, above = "anatomy/src/low/a.cpp", "anatomy/src/high/b.cpp"
    assert foreign_includes(below, '#include "high/b.hpp"\n', "anatomy", folders["anatomy/src/low"])
    assert not foreign_includes(above, '#include "low/a.hpp"\n', "anatomy", folders["anatomy/src/high"])
    with pytest.raises(AssertionError, match="not declared before"):
        reachable({"vci/high": ["vci/low"], "vci/low": []})


def hidden_names(text):
    """Functions, types and constants that a C++ source keeps in its unnamed namespace. Aliases are left out."""
    names, inside = set(), False
    kind = r"(?:template <[^>]*> )?(?:struct|class|enum class|constexpr [\w:]+|const [\w:]+|\w[\w:<>,&* ]*?)"
    for line in text.splitlines():
        if line in ("namespace {", "} // namespace"):
            inside = line == "namespace {"
        elif inside and not line.startswith(("namespace", "using", "return")):
            match = re.match(kind + r" (\w+)\s*(?:\(|=|\{|;|$)", line)
            names |= {match[1]} if match else set()
    return names


@pytest.mark.parametrize("part", cpp_parts())
def test_no_two_files_of_a_folder_hide_the_same_name(part):
    """The files of a folder are compiled as one. An overload in another file could then be taken without any error."""
    for folder in declared_folders((ROOT / part / "CMakeLists.txt").read_text(), part):
        places = {}
        for source in tracked(f"{folder}/*.cpp"):
            text = (ROOT / source).read_text() if str(source.parent) == folder else ""
            for name in hidden_names(text):
                places.setdefault(name, []).append(source.name)
        twice = {name: files for name, files in places.items() if len(files) > 1}
        assert not twice, f"{folder}: {twice}; rename one, or share it by a header"


def test_hidden_names_are_found():
    """Functions, constants and types count; what others see, calls and members do not."""
    text = "int seen();\nnamespace {\nconstexpr double a = 1;\nstruct B {\n  int c;\n};\nstd::vector<int> d(int e) {\n"
    assert hidden_names(text + "  f(e);\n}\n} // namespace\nvoid g() {\n}\n") == {"a", "B", "d"}


def imported(text, package):
    """Full names that a Python module of `package` imports, as module or as name of a module."""
    names = set()
    for node in ast.walk(ast.parse(text)):
        if isinstance(node, ast.Import):
            names |= {alias.name for alias in node.names}
        elif isinstance(node, ast.ImportFrom):
            above = package.split(".")[: len(package.split(".")) - node.level + 1] if node.level else []
            base = ".".join(above + ([node.module] if node.module else []))
            names |= {f"{base}.{alias.name}" for alias in node.names}
    return names


def folder_of(path, folders):
    """The longest of the folders that holds a path, or None."""
    return max((f for f in folders if f"{path}/".startswith(f"{f}/")), key=len, default=None)


def foreign_imports(name, text, layers):
    """Imports of a module from folders that its own is not declared to use."""
    own = folder_of(name, layers)
    wrong = []
    for module in sorted(imported(text, ".".join(name.parent.parts))):
        other = folder_of(module.replace(".", "/"), layers)
        if other and other not in (own, *layers[own]):
            wrong.append(f"{name} imports {module}; {own} may import {layers[own]}")
    return wrong


def layers_of_python():
    """{folder: what it may import} as layers.yaml has it."""
    return yaml_reader.read(ROOT / "tests/unit/layers.yaml").data


def without_stars(layers):
    """The layers with each FOLDER/* replaced by that folder and all below it, except the importing one itself."""

    def folders(name, own):
        top = name.removesuffix("/*")
        return [name] if top == name else [f for f in layers if f"{f}/".startswith(f"{top}/") and f != own]

    return {own: [folder for name in names for folder in folders(name, own)] for own, names in layers.items()}


def import_sentence(package, layers):
    """How the docstring of a package names what it may import: the folders in layers.yaml, with points for slashes."""
    layer = folder_of(package, layers)
    names = ([] if layer == package else [layer]) + layers[layer]
    return f"May import: {', '.join(names).replace('/', '.') or 'no other folder'}."


def test_imports_go_one_way():
    """No folder of Python modules imports from a folder that layers.yaml does not grant it."""
    layers = without_stars(layers_of_python())
    reachable(dict(layers))
    modules = [m for m in tracked("*.py") if m.parts[0] not in ("tests", "setup", "docs")]
    wrong = [f"{m}: its folder is not in layers.yaml" for m in modules if folder_of(m, layers) is None]
    for module in modules:
        if folder_of(module, layers):
            wrong += foreign_imports(module, (ROOT / module).read_text(), layers)
    assert modules and not wrong, "\n".join(wrong)


def test_packages_say_what_they_may_import():
    """The docstring of each package ends with the folders of layers.yaml, after saying what the package holds.

    The docstring of `vci` is left out, since it is the help for those who use the package in their own programs.
    """
    layers, wrong = layers_of_python(), []
    packages = [m.parent for m in tracked("*/__init__.py") if m.parts[0] not in ("tests", "setup", "docs", "vci")]
    for package in packages:
        docstring = ast.get_docstring(ast.parse((ROOT / package / "__init__.py").read_text())) or ""
        sentence = import_sentence(str(package), layers)
        held, found, rest = " ".join(docstring.split()).partition(sentence)
        if not (held and found) or rest:
            wrong.append(f"{package}/__init__.py: its docstring does not end with: {sentence}")
    assert packages and not wrong, "\n".join(wrong)


def test_folders_of_python_are_small():
    """A folder holds a dozen Python modules at most, its command line and package docstring not counted."""
    modules = {}
    for module in tracked("*.py"):
        if module.parts[0] not in ("tests", "setup", "docs") and module.stem not in ("__init__", "__main__"):
            modules.setdefault(str(module.parent), []).append(module.stem)
    large = [f"{folder}: {len(names)} modules" for folder, names in modules.items() if len(names) > MODULES_PER_FOLDER]
    assert modules and not large, "\n".join(large)


def test_an_import_against_the_order_is_found():
    """The check sees an import of another part, relative ones too, and lets those of common pass."""
    layers = {"common": [], "flow": ["common"], "flow/core": ["common"], "reports": ["common"]}
    core, report = pathlib.PurePath("flow/core/a.py"), pathlib.PurePath("reports/b.py")
    assert foreign_imports(report, "def f():\n    from flow import core\n", layers)
    assert foreign_imports(core, "from .. import sweep\n", layers)
    assert foreign_imports(core, "import flow.sweep\n", layers)
    layers["reports/__main__.py"] = ["common", "flow"]  # a file as a layer binds only that file
    assert foreign_imports(report, "from flow import core\n", layers)
    assert not foreign_imports(report.with_name("__main__.py"), "from flow import sweep\n", layers)
    assert not foreign_imports(core, "from common.errors import InputError\nfrom . import b\nimport numpy\n", layers)


def test_a_star_stands_for_a_folder_and_all_below_it():
    layers = {"common": [], "common/documents": ["common"], "flow/core": ["common/*"], "flow": ["common/*", "flow/*"]}
    common = ["common", "common/documents"]
    assert without_stars(layers) == {**layers, "flow/core": common, "flow": [*common, "flow/core"]}
    assert import_sentence("flow", layers) == "May import: common.*, flow.*."
    assert import_sentence("flow/core/inner", layers) == "May import: flow.core, common.*."
    assert import_sentence("common", layers) == "May import: no other folder."
