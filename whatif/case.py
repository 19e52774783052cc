"""A finished case whose procedure or inputs are varied. Its files are read once."""

import dataclasses
import functools
import pathlib

from common.documents import config, json_reader
from flow import settings as flow_settings
from flow.geometry import centreline
from flow.inputs import boundary, lumen_summary
from flow.reduced import network

BEFORE, PLANNED = "pre", "vci"


@dataclasses.dataclass(frozen=True)
class Case:
    """A case in the folder results/cases/<case>. programs: folder of the programs `vci` and `lumen`.

    edge_mm, spacing_mm: edge length of surfaces and distance of sections, as options of `lumen process`.
    """

    folder: pathlib.Path
    programs: pathlib.Path = pathlib.Path("build")
    edge_mm: float = 0.4
    spacing_mm: float = 0.5

    def anatomy(self, state=BEFORE):
        """Folder of a state's anatomy."""
        return self.folder / "anatomy" if state == BEFORE else self.folder / state / "anatomy"

    def json(self, name):
        """The document of a JSON file, named relative to the case's folder. Raises InputError."""
        return json_reader.read(self.folder / name, "the study's file").data

    @functools.cached_property
    def scene(self):
        """The content of scene.json of the planned procedure."""
        return self.json("vci/scene.json")

    @functools.cached_property
    def boundary(self):
        """The content of boundary.json, checked."""
        path = self.folder / "flow" / "boundary.json"
        document = self.json("flow/boundary.json")
        boundary.check(document, path)
        return document

    @functools.cached_property
    def flow_settings(self):
        """The case's settings of the flow."""
        return flow_settings.make(**self.json("settings/flow.json"))

    @functools.cached_property
    def centrelines(self):
        """The centrelines before the procedure."""
        return centreline.read(self.anatomy() / "centreline.vtp")

    @functools.cached_property
    def anatomy_before(self):
        """The content of anatomy.json before the procedure."""
        return lumen_summary.read(self.anatomy() / "anatomy.json", "ends", "branches")

    def lumen(self, anatomy_folder):
        """(content of anatomy.json, table of sections.csv) of a lumen, for the 1D network. Raises InputError."""
        summary = lumen_summary.read(anatomy_folder / "anatomy.json", "branches")
        return summary, network.read_sections(anatomy_folder / "sections.csv")

    def flow_result(self, state):
        """The content of ffr.json of a state. Raises InputError."""
        return self.json(f"flow/{state}/ffr.json")


def read_patient(case_file):
    """(patient, measured) of a case file: the patient's data, and the FFR by pressure wire or None."""
    document = config.load_case(case_file)
    return document["patient"], document.get("measured")
