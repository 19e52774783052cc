"""Drawn vessels, before and after a procedure, and their registration as the command does it."""

import numpy as np
from scipy.spatial.transform import Rotation

from anatomy.register import placement_checks, search, axes_refinement
from anatomy.register.match import match_branches
from anatomy.register.placement import Target
from anatomy.register.tree import STEP_MM, Line, Tree

NO_LANDMARKS = (np.zeros((0, 3)), np.zeros((0, 3)))
ROTATION = Rotation.from_rotvec(np.radians(40) * np.array([1, 2, -1.5]) / np.linalg.norm([1, 2, -1.5]))
TRANSLATION = 60 * np.array([0.6, -0.64, 0.48])


def curve(length_mm, seed, start=(0.0, 0.0, 0.0), heading=None, bend=0.06):
    """Points STEP_MM apart of a smooth curve whose direction wanders, curvature about `bend` (1/mm)."""
    random = np.random.default_rng(seed)
    count = int(length_mm / STEP_MM) + 1
    s = np.arange(count) * STEP_MM
    direction = np.array([1.0, 0.0, 0.0]) if heading is None else np.asarray(heading) / np.linalg.norm(heading)
    waves, points = random.uniform(0, 2 * np.pi, (2, 3)), [np.asarray(start, float)]
    for at in s[1:]:
        push = np.sin(2 * np.pi * at / 37 + waves[0]) + 0.7 * np.sin(2 * np.pi * at / 19 + waves[1])
        direction = direction + bend * STEP_MM * (push - direction * (push @ direction))
        direction = direction / np.linalg.norm(direction)
        points.append(points[-1] + STEP_MM * direction)
    return np.array(points)


def tree_of(branches, parents, radius=1.5):
    """A Tree of {name: points}, {name: (parent, sample where it leaves)}."""
    lines = {
        name: Line(points, np.linspace(radius, 0.8 * radius, len(points)), np.full(len(points), name))
        for name, points in branches.items()
    }
    routes, ends = {}, []
    for name, line in lines.items():
        pieces, at = [line], parents.get(name)
        while at:
            parent = lines[at[0]]
            cut = slice(0, at[1] + 1)
            pieces.insert(0, Line(parent.points[cut], parent.radius[cut], parent.branch[cut]))
            at = parents.get(at[0])
        routes[name] = Line(*(np.concatenate([getattr(p, k) for p in pieces]) for k in ("points", "radius", "branch")))
        ends.append({"name": f"outlet{len(ends) + 1}", "kind": "outlet", "branch": name})
        ends[-1].update(centre_mm=line.points[-1].tolist(), normal=[0.0, 0.0, 1.0], region_id=1 + len(ends))
    inlet = {"name": "inlet", "kind": "inlet", "branch": "main", "region_id": 1, "normal": [0.0, 0.0, 1.0]}
    inlet["centre_mm"] = lines["main"].points[0].tolist()
    return Tree(lines, routes, {"ends": [inlet, *ends]})


def vessel(seed=1):
    """A vessel of 60 mm with side branches at 20 and 40 mm."""
    main = curve(60, seed)
    side1 = curve(15, seed + 10, main[40], np.cross(main[41] - main[40], [0, 0, 1]) + 0.5 * (main[41] - main[40]))
    side2 = curve(12, seed + 20, main[80], np.cross(main[81] - main[80], [0, 1, 0]) + 0.5 * (main[81] - main[80]))
    return tree_of({"main": main, "side1": side1, "side2": side2}, {"side1": ("main", 40), "side2": ("main", 80)})


def moved(tree, keep=None, names=None, noise=0.05, change=None):
    """The tree turned by 40 degrees and moved by 60 mm, with noise; keep: {name: slice}, names: {old: new}."""
    random, branches, parents = np.random.default_rng(3), {}, {}
    for name, line in tree.branches.items():
        rows = (keep or {}).get(name, slice(None))
        if rows is not None:
            points = line.points if change is None else change(line.points)
            points = points[rows] + noise * random.standard_normal(points[rows].shape)
            branches[(names or {}).get(name, name)] = ROTATION.apply(points) + TRANSLATION
    first = (keep or {}).get("main", slice(None)).start or 0
    for name, at in (("side1", 40), ("side2", 80)):
        if (names or {}).get(name, name) in branches:
            parents[(names or {}).get(name, name)] = ("main", at - first)
    return tree_of(branches, parents)


def registered(pre, post, landmarks=NO_LANDMARKS):
    """(SearchResult, Match, Target) of a registration. Refuses what the command refuses."""
    placement_checks.check_landmarks("case", pre, post, landmarks)
    target = Target(pre)
    found = axes_refinement.refine_by_axes(target, post, search.find_placement(pre, post, landmarks), landmarks)
    match = match_branches(target, post, found.placement)
    placement_checks.check_handedness("case: post", pre, post, target, found, match, landmarks)
    placement_checks.check_direction("case: post", pre, post, target, found, landmarks)
    placement_checks.check_fit("case: post", target, post, found, match, landmarks)
    placement_checks.check_place_along("case: post", target, post, found, match, landmarks)
    return found, match, target


def straight(length_mm, radius=1.5):
    points = np.zeros((int(length_mm / STEP_MM) + 1, 3))
    points[:, 2] = np.arange(len(points)) * STEP_MM
    line = Line(points, np.full(len(points), radius), np.full(len(points), "main"))
    return Tree({"main": line}, {"main": line}, vessel().summary)


def bent(first, last, radius=1.5, bow_mm=0.0):
    """A part of a vessel of 30 mm along z, bowed by bow_mm. Its axis wanders by a tenth of a millimetre."""
    z = np.arange(first, last, STEP_MM)
    sway = 0.1 * np.sin(z / 2), 0.1 * np.cos(z / 3) + bow_mm * np.sin(2 * np.pi * z / 30)
    return tree_of({"main": np.column_stack([*sway, z])}, {}, radius)


def unbranched_tree(points):
    return tree_of({"main": points}, {})
