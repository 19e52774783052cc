"""The half-maximum arm of the study: its cases, settings and files.

The arm makes the comparison in CT a second time, with lumens segmented at half maximum of the intensity.
"""

import json

from workflow.inputs import CT_STATES

NAME = "half_maximum"  # the method of segmentation, and the arm's folder in a case's folder
STATES = ("ct_pre", *CT_STATES)  # states whose lumens the arm makes itself


class HalfMaximum:
    """Cases, settings and input functions for the rules of the half-maximum arm, from the study's `Inputs`."""

    def __init__(self, inputs):
        self.inputs = inputs

    def cases(self, cases):
        """The cases with a CT, except those whose settings already ask for half maximum."""
        of = self.inputs.configuration.settings
        return [
            case
            for case in cases
            if "ct" in self.inputs.states(case) and of(case)["ct"]["segmentation"]["method"] != NAME
        ]

    def settings(self, wildcards):
        """The section `ct` of the case as JSON text, with the segmentation at half maximum."""
        settings = self.inputs.configuration.settings(wildcards.case)["ct"]
        changed = settings | {"segmentation": settings["segmentation"] | {"method": NAME}}
        return json.dumps(changed, sort_keys=True)

    def lumen(self, wildcards):
        """As `Inputs.state_lumen`, in the arm's folder."""
        folder = f"{self.inputs.results}/cases/{wildcards.case}"
        return self.inputs.state_lumen(wildcards).replace(folder, f"{folder}/{NAME}", 1)

    def compared(self, wildcards):
        """Anatomy and flow files of the states without a CT. The arm's metrics compare its lumens with these states."""
        names = ("{anatomy}/centreline.vtp", "{anatomy}/sections.csv", "{anatomy}/anatomy.json")
        flow = ("flow/{state}/ffr.json", "flow/{state}/pullback.csv")
        seen = tuple(f"/{state}/" for state in CT_STATES)
        files = self.inputs.of_states(*names, *flow)(wildcards)
        return [file for file in files if not any(state in file for state in seen)]

    def ffr(self, wildcards):
        """[file with the FFR of the arm's lumens]; empty if the 1D network cannot be calibrated on the case's flow."""
        varied = self.inputs.varied([wildcards.case])
        return [f"{self.inputs.results}/cases/{wildcards.case}/{NAME}/ffr.json"] if varied else []
