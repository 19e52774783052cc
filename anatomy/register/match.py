"""Matches the branches of the lumen after the procedure with those before: names, shared stretches, residuals."""

import dataclasses

import numpy as np

from .tree import STEP_MM

KEPT = 0.8  # share of the samples in the deciding residual; the worst fifth is left out, as a stent straightens


@dataclasses.dataclass(frozen=True)
class Match:
    """names: {branch of the post lumen: branch before, or a new name}; missing: branches before without one after;
    new: {new name: branch of the post lumen}; shared: {branch before: (first, last s_mm) that the post lumen covers};
    residual_mm: (n,) distances of the shared samples from the axes before; usual_radius_mm: usual radius there, before.
    """

    names: dict
    missing: list
    new: dict
    shared: dict
    residual_mm: np.ndarray
    usual_radius_mm: float

    @property
    def trimmed_mm(self):
        """Root mean square of the smallest KEPT of the residuals."""
        kept = np.sort(self.residual_mm)[: max(1, int(KEPT * len(self.residual_mm)))]
        return float(np.sqrt(np.mean(kept**2)))


def matched(target, tree, placement):
    """The Match of a placed Tree with a Target.

    The route to an end follows the axes before the procedure, up to the last sample within a usual radius of them. The
    end belongs to the branch of that sample. Of two ends on the same branch, the one that follows it further gets its
    name, and the other gets a new name.
    """
    claims = {name: _claim(target, route, placement) for name, route in tree.routes.items()}
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
        # a branch is compared with the branch of its name and, up to its take-off, with that branch's parents
        inside = np.isin(target.names[nearest], _with_parents(target, names[name])) & ~_past_an_end(
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


def _claim(target, route, placement):
    """(branch before, s_mm on it) of a route's last sample that lies on the axes before; (None, -1) without one."""
    _, distance, nearest = target.offsets(placement.apply(route.points))
    on = np.flatnonzero(distance < target.usual_radius_mm)
    if not on.size:
        return None, -1.0
    return str(target.names[nearest[on[-1]]]), float(_s_mm(target, nearest[on[-1]])[0])


def _with_parents(target, name):
    """The names of the branches before along the route to the branch `name`, with itself; none for a new name."""
    return sorted(set(target.tree.routes[name].branch)) if name in target.tree.routes else []


def _s_mm(target, samples):
    """Arc length along their branches of samples (n,) of a Target, in mm."""
    first = {name: int(np.flatnonzero(target.names == name)[0]) for name in target.tree.branches}
    return np.array([(sample - first[target.names[sample]]) * STEP_MM for sample in np.atleast_1d(samples)])


def _past_an_end(target, points, nearest):
    """Mask (n,) of the points that are beyond a branch's end, which is their nearest sample."""
    names = target.names
    last = np.append(names[1:] != names[:-1], True)
    first = np.append(True, names[1:] != names[:-1])
    along = np.einsum("ij,ij->i", points - target.points[nearest], target.tangents[nearest])
    return (last[nearest] & (along > STEP_MM / 2)) | (first[nearest] & (along < -STEP_MM / 2))


def _number(name):
    return 0 if name == "main" else int(name.removeprefix("side"))
