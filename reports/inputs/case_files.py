"""Paths of each state's files in a case's folder (docs/design.md)."""

import dataclasses
import pathlib

from common.errors import InputError
from common.patient.states import CT_STATES, PREDICTED_FROM_CT, STATES
from reports.inputs.reading import entry, number, read_json

SEGMENTATION_ARMS = ("half_maximum",)  # further segmentations of the CT volumes; each has a folder in the case's folder


def states_in_3d(states):
    """The `states` that are shown in 3D: all but the predictions from CT, which look like the other predictions."""
    return [state for state in states if state not in PREDICTED_FROM_CT]


@dataclasses.dataclass(frozen=True)
class CaseFiles:
    """The files of one case below its folder.

    arm: "" for the study's own segmentation of the CT volumes, or the name of a further one (SEGMENTATION_ARMS). A
    further one gives the lumens of the states CT_STATES. Their FFR then comes from the calibrated 1D flow network, not
    from 3D flow.
    """

    case: str
    folder: pathlib.Path
    arm: str = ""

    def __post_init__(self):
        if not self.folder.is_dir():
            raise InputError("the case's folder is missing", self.folder, "no such folder", "run the case first")

    @property
    def scene(self):
        return self.folder / "vci" / "scene.json"

    @property
    def boundary(self):
        return self.folder / "flow" / "boundary.json"

    @property
    def deployment(self):
        return self.folder / "vci" / "deployment.json"

    @property
    def metrics(self):
        return self.folder / "metrics.json"

    @property
    def truth(self):
        return self.folder / "source" / "truth.json"

    def anatomy(self, state):
        """The anatomy folder of a state. For `pre` it lies directly in the case's folder."""
        if self.arm and state in CT_STATES:
            return self.folder / self.arm / state / "anatomy"
        return self.folder / "anatomy" if state == "pre" else self.folder / state / "anatomy"

    def lumen(self, state):
        """The lumen's surface as the anatomy step of this state wrote it."""
        return self.anatomy(state) / "lumen.vtp"

    def segmentation(self, state):
        """The segmentation.json of a state's CT."""
        return self.folder / self.arm / "ct" / state / "segmentation.json"

    def lumen_record(self):
        """(kind, path) of the file that says how a real patient's lumen was made from images, or None.

        kind: "ct" or "contours".
        """
        found = [
            ("ct", self.folder / "source" / "segmentation.json"),
            ("contours", self.folder / "source" / "contours.json"),
        ]
        return next(((what, path) for what, path in found if path.exists()), None)

    def flow(self, state):
        return self.folder / "flow" / state

    @property
    def registration(self):
        """The file that says how the lumen after the real procedure was aligned with the lumen before it."""
        return self.folder / "post" / "registration.json"

    def has_flow(self, state):
        """Whether the 3D flow of a state was solved.

        It was not solved in an arm's own lumens, nor for `post` if the case compares only areas.
        """
        if self.arm and state in CT_STATES:
            return False
        if state != "post":
            return True
        return entry(read_json(self.registration, "anatomy register"), "compare", self.registration) == "flow"

    def network_ffr(self, state):
        """FFR of an arm's lumen by the calibrated 1D network, with its error, in the form of ffr.json.

        None without an arm, for a state whose lumen does not depend on the arm, or if the network was not solved.
        """
        path = self.folder / self.arm / "ffr.json"
        if not self.arm or state not in CT_STATES or not path.exists():
            return None
        document = read_json(path, "whatif lumens")
        ffr, error = (number(document, key, path) for key in (f"lumens.{state}.ffr", "error"))
        return {"ffr": ffr, "model": entry(document, "model", path), "error_estimate": {"ffr": error}}

    @property
    def deployed_lumen(self):
        """The lumen that `vci deploy` wrote. Its points have the engine's values, which the anatomy step drops."""
        return self.folder / "vci" / "lumen.vtp"

    def stent_files(self):
        """Files of the deployed stents' smooth surfaces, in the order of `stents` in deployment.json."""
        found = [path for path in (self.folder / "vci" / "devices").glob("stent*.vtp") if path.stem[5:].isdigit()]
        return sorted(found, key=lambda path: int(path.stem[5:]))

    def strut_files(self):
        """Files of the stents' struts after deployment, sorted by name. Balloons have none: they leave the vessel."""
        return sorted((self.folder / "vci" / "devices").glob("*_struts.vtp"))

    def states(self):
        """The states of which there is any result, in the order of STATES.

        A state with only a part of its results counts as present, so that the missing part is reported.
        """
        return [
            state
            for state in STATES
            if (self.anatomy(state) / "sections.csv").exists() or (self.flow(state) / "ffr.json").exists()
        ]
