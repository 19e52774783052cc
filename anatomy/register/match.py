"""Matches the branches of the lumen after the procedure with those before: names, shared stretches, residuals."""

import dataclasses

import numpy as np

from .tree import STEP_MM

KEPT_SHARE = 0.8  # share of the samples in trimmed_mm: a stent straightens the vessel, so the worst fifth is left out


@dataclasses.dataclass(frozen=True)
class Match:
    """How the branches after the procedure correspond to those before.

    names: {branch after: branch before, or a new name}. missing_branches: names of branches before that have no partner
    after. new_branches: {new name: branch after} of branches without a partner before. shared_ranges: {branch before:
    (first, last s_mm) that the lumen afterwards covers}. residual_mm (n,): distances of the shared samples from the
    axes before. usual_radius_mm: median radius of the lumen before at these samples.
    """

    names: dict
    missing_branches: list
    new_branches: dict
    shared_ranges: dict
    residual_mm: np.ndarray
    usual_radius_mm: float

    @property
    def trimmed_mm(self):
        """The residual in mm that judges a placement: root mean square of residual_mm without the worst fifth."""
        kept = np.sort(self.residual_mm)[: max(1, int(KEPT_SHARE * len(self.residual_mm)))]
        return float(np.sqrt(np.mean(kept**2)))


def match_branches(target, tree, placement):
    """The Match of a placed Tree with a Target.

    The route from the inlet to an end follows the axes before the procedure, up to its last sample within a usual
    radius of them. The end belongs to the branch whose axis is nearest to that sample. If two ends belong to the same
    branch, the one that follows it farther gets its name, and the other gets a new name.
    """
    claims = {name: _claimed_branch(target, route, placement) for name, route in tree.routes.items()}
    names, new = {}, {}
    for name, (branch, reach) in sorted(claims.items(), key=lambda item: (-item[1][1], item[0] != "main", item[0])):
        if branch is not None and branch not in names.values():
            names[name] = branch
    free = 1 + max(_number(name) for name in target.tree.branches)
    for name in tree.branches:
        if name not in names:
            names[name] = f"side{free + len(new)}"
            new[names[name]] = name
    missing = [name for name in target.tree.branches if name not in names.values()]
    reached, residuals, radii = {}, [], []
    for name, line in tree.branches.items():
        points = placement.apply(line.points)
        _, distance, nearest = target.offsets(points)
        # A branch is compared with the branch before that has its name. Up to the take-off it is compared with that
        # branch's parents.
        inside = np.isin(target.names[nearest], _with_parents(target, names[name])) & ~_is_past_end(
            target, points, nearest
        )
        residuals.append(distance[inside])
        radii.append(target.radius[nearest[inside]])
        for branch, s in zip(target.names[nearest[inside]], _s_mm(target, nearest[inside])):
            first, last = reached.get(str(branch), (s, s))
            reached[str(branch)] = min(first, float(s)), max(last, float(s))
    shared = {branch: reached[branch] for branch in target.tree.branches if branch in reached}
    residual = np.concatenate(residuals)
    usual_radius = float(np.median(np.concatenate(radii))) if len(residual) else target.usual_radius_mm
    return Match(names, missing, new, shared, residual, usual_radius)


def _claimed_branch(target, route, placement):
    """The branch before that a route ends on: (its name, arc length on it in mm).

    The place is that of the route's last sample within a usual radius of the axes before. Without such a sample the
    result is (None, -1). route: a Line.
    """
    _, distance, nearest = target.offsets(placement.apply(route.points))
    on = np.flatnonzero(distance < target.usual_radius_mm)
    if not on.size:
        return None, -1.0
    return str(target.names[nearest[on[-1]]]), float(_s_mm(target, nearest[on[-1]])[0])


def _with_parents(target, name):
    """Branches before on the route from the inlet to the end of branch `name`, itself included; [] for a new name."""
    return sorted(set(target.tree.routes[name].branch)) if name in target.tree.routes else []


def _s_mm(target, samples):
    """Arc lengths (n,) in mm of samples of a Target along their own branches. samples (n,): their numbers."""
    first = {name: int(np.flatnonzero(target.names == name)[0]) for name in target.tree.branches}
    return np.array([(sample - first[target.names[sample]]) * STEP_MM for sample in np.atleast_1d(samples)])


def _is_past_end(target, points, nearest):
    """(n,) of bool: which points (n, 3) lie beyond a branch's end. nearest: (n,) numbers of the nearest samples."""
    names = target.names
    last = np.append(names[1:] != names[:-1], True)
    first = np.append(True, names[1:] != names[:-1])
    along = np.einsum("ij,ij->i", points - target.points[nearest], target.tangents[nearest])
    return (last[nearest] & (along > STEP_MM / 2)) | (first[nearest] & (along < -STEP_MM / 2))


def _number(name):
    """Number of a branch by its name: 0 for main, 1 for side1, ..."""
    return 0 if name == "main" else int(name.removeprefix("side"))
