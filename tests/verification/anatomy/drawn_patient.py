"""A drawn patient's truth, and lofts of its branches."""

import json

import lofts
import numpy as np
import surfaces

STENOSIS_PERCENT = 3.0  # per cent of the diameter; throats that differ by less count as one place
ROOT_SHARE = 0.8  # of the parent's radius: where a lofted side branch begins, it widens by 45 degrees


class Patient:
    """A drawn patient's truth: axes, radii and worst lesion; and its exact surface."""

    def __init__(self, folder):
        self.truth = json.loads((folder / "truth.json").read_text())
        self.points, self.triangles = surfaces.arrays(surfaces.read(folder / "lumen.vtp"))
        self.branches = [
            {key: np.array(branch[key]) for key in ("s_mm", "points_mm", "radius_mm", "healthy_radius_mm")}
            for branch in self.truth["branches"]
        ]

    def ends(self):
        """[(centre (3,), outward direction (3,), radius)] of the inlet and the outlets, mm."""
        found = []
        for number, branch in enumerate(self.branches):
            for at, beside in ((0, 1), (-1, -2)) if number == 0 else ((-1, -2),):
                outward = branch["points_mm"][at] - branch["points_mm"][beside]
                outward /= np.linalg.norm(outward)
                found.append((branch["points_mm"][at], outward, branch["radius_mm"][at]))
        return found

    def lesion(self):
        """(places (n, 3) mm, least and most diameter stenosis in per cent) of the worst lesion, or None.

        Of two throats of nearly equal width either may be the worst, since no measurement can separate them. Where a
        side branch opens a throat, the branch's tube is not the lumen. The measured stenosis then lies between that of
        the tube and the worst one of a section that no other branch touches. So does its place.
        """
        every = [(lesion, k) for k, branch in enumerate(self.truth["branches"]) for lesion in branch["lesions"]]
        if not every:
            return None
        worst, k = max(every, key=lambda one: one[0]["true_diameter_stenosis_percent"])
        s, percent = self.branches[k]["s_mm"], worst["true_diameter_stenosis_percent"]
        throat = np.argmin(np.abs(s - worst["true_s_mla_mm"]))
        within = np.abs(s - worst["centre_s_mm"]) < 0.5 * worst["length_mm"]
        narrowed = 1 - self.branches[k]["radius_mm"] / self.branches[k]["healthy_radius_mm"]
        if self.untouched(k)[throat]:
            alike = within & (100 * narrowed > percent - STENOSIS_PERCENT)
            alike[throat] = True
            return self.branches[k]["points_mm"][alike], percent, percent
        stenosis = np.where(self.untouched(k) & within, narrowed, 0)
        beside = np.argmax(stenosis)
        reach = abs(s[beside] - s[throat])
        places = np.abs(s - s[throat]) <= reach
        return self.branches[k]["points_mm"][places], 100 * float(stenosis[beside]), percent

    def untouched(self, number):
        """Whether the tube of a branch is clear of every other one's, at each of its samples: (n,) bool."""
        x, r = self.branches[number]["points_mm"], self.branches[number]["radius_mm"]
        clear = np.full(len(r), True)
        for k, other in enumerate(self.branches):
            if k != number:
                away = np.linalg.norm(x[:, None] - other["points_mm"][None], axis=2)
                clear &= (away - other["radius_mm"]).min(axis=1) > r
        return clear

    def pieces(self, corners, spacing, caps="fan", slant=0.0, stub=None):
        """A loft of each branch. A side branch begins inside its parent. With `stub` it ends this many mm outside the
        parent."""
        made = []
        for number, branch in enumerate(self.branches):
            s, x, r = branch["s_mm"], branch["points_mm"], branch["radius_mm"]
            length = s[-1]
            if number:
                x, r = self.from_parent(number)
            if stub is not None and number:
                length = min(length, self.outside(number) + stub)
            axis = _extended(s, x)
            radius = lambda at, s=s, r=r: np.interp(at, s, r)  # noqa: E731
            made.append(lofts.loft(axis, radius, length, corners, spacing, caps, slant))
        return made

    def from_parent(self, number):
        """(axis (n, 3), radii (n,)) mm of a side branch that starts on its parent's lumen axis, within its lumen.

        Plaque moves the lumen away from the healthy axis, where the drawn branch starts as wide as it is outside.
        """
        branch, parent = self.branches[number], self.parent(number)
        root = np.argmin(np.abs(parent["s_mm"] - self.truth["branches"][number]["s_on_parent_mm"]))
        s = branch["s_mm"]
        fade = np.clip(1 - s / self.outside(number), 0, 1)
        axis = branch["points_mm"] + fade[:, None] * (parent["points_mm"][root] - branch["points_mm"][0])
        return axis, np.minimum(branch["radius_mm"], ROOT_SHARE * parent["radius_mm"][root] + s)

    def parent(self, number):
        """The branch that a side branch leaves."""
        names = [one["name"] for one in self.truth["branches"]]
        return self.branches[names.index(self.truth["branches"][number]["parent"])]

    def outside(self, number):
        """Arc length (mm) at which a side branch leaves its parent's wall."""
        branch, parent = self.branches[number], self.parent(number)
        away = np.linalg.norm(branch["points_mm"][:, None] - parent["points_mm"][None], axis=2)
        clear = (away - parent["radius_mm"][None]).min(axis=1) - branch["radius_mm"]
        return float(branch["s_mm"][np.argmax(clear > 0)])


def _extended(s, x):
    """The axis as a function of arc length, straight beyond its ends."""

    def axis(at):
        at = np.asarray(at, float)
        inside = np.column_stack([np.interp(at, s, x[:, k]) for k in range(3)])
        first, last = (x[1] - x[0]) / (s[1] - s[0]), (x[-1] - x[-2]) / (s[-1] - s[-2])
        return inside + np.minimum(at - s[0], 0)[:, None] * first + np.maximum(at - s[-1], 0)[:, None] * last

    return axis
