"""anatomy.json, the anatomy step's summary of a lumen: the parts that the flow step reads (ends, branches, lesions)."""

from common.documents import json_reader, schema
from common.errors import InputError

# Files of the anatomy step for one lumen.
ANATOMY_STEP_FILES = ("lumen.vtp", "centreline.vtp", "sections.csv", "anatomy.json")
LENGTH_TOLERANCE = 0.005  # largest relative difference of a branch's lengths in anatomy.json and centreline.vtp


def read(path, *needed):
    """The document of anatomy.json at `path`, checked for the keys `needed`. Raises InputError."""
    document = json_reader.read(path, "anatomy.json")
    check(document.data, path, *needed)
    return document.data


def check(data, where, *needed):
    """Raises InputError unless data is a document of the anatomy step that has the keys `needed`."""
    document = json_reader.Document(where, data)
    document.check_finite()
    rules = {**schema.read("lumen_summary"), "required": needed}
    schema.validate(document, rules, "a document of the anatomy step", "give the anatomy.json of `lumen process`")
    if "branches" in data:
        _check_tree(data["branches"], where)


def check_lengths(data, tree, where):
    """Raises InputError unless the branches in anatomy.json are as long as in a geometry.centreline.Tree.

    Branches without a length in anatomy.json are not checked.
    """
    for branch in data.get("branches", []):
        given, found = branch.get("length_mm"), tree[branch["name"]].length_mm
        if given is not None and abs(given - found) > LENGTH_TOLERANCE * found:
            value = f"length {given:.4g} mm, of the centreline {found:.4g} mm"
            remedy = "give anatomy.json and centreline of one lumen, both in mm"
            raise InputError("a branch of another lumen", f"{where}: {branch['name']}", value, remedy)


def _check_tree(branches, where):
    """Raises InputError unless exactly one branch has no parent, and all others descend from it."""
    names = [branch["name"] for branch in branches]
    if len(set(names)) < len(names):
        raise InputError("two branches have the same name", f"{where}: branches", names, "run the anatomy step again")
    reached = [branch["name"] for branch in branches if branch["parent"] is None]
    if len(reached) != 1:
        remedy = "one branch has the inlet and no parent"
        raise InputError("branches are not one tree", f"{where}: branches", f"without a parent: {reached}", remedy)
    for name in reached:
        reached += [branch["name"] for branch in branches if branch["parent"] == name]
    lost = [name for name in names if name not in reached]
    if lost:
        raise InputError("branches are not one tree", f"{where}: branches", lost, "let each parent be a branch")
    for branch in branches:
        if branch["parent"] is not None and branch["s_on_parent_mm"] is None:
            remedy = "give where it leaves its parent, in mm"
            raise InputError("branch without a place", f"{where}: {branch['name']}", "s_on_parent_mm null", remedy)
