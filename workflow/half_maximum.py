"""Cases, settings and files of the half-maximum arm of the study.

This arm makes the comparison in CT a second time, with lumens segmented at half of the maximum intensity.
"""

import json

from common.patient.states import CT_PRE, CT_STATES

ARM_NAME = "half_maximum"  # the method of segmentation, and the arm's folder in a case's folder
ARM_STATES = (CT_PRE, *CT_STATES)  # states whose lumens the arm makes itself


class HalfMaximum:
    """Cases, settings and input functions for the rules of the half-maximum arm, from the study's `Inputs`."""

    def __init__(self, inputs):
        self.inputs = inputs

    def arm_cases(self, cases):
        """The cases with a CT, except those whose settings already ask for half maximum."""
        settings_of = self.inputs.configuration.settings
        return [
            case
            for case in cases
            if "ct" in self.inputs.states(case) and settings_of(case)["ct"]["segmentation"]["method"] != ARM_NAME
        ]

    def ct_settings(self, wildcards):
        """The section `ct` of the case as JSON text, with the segmentation at half maximum."""
        settings = self.inputs.configuration.settings(wildcards.case)["ct"]
        changed = settings | {"segmentation": settings["segmentation"] | {"method": ARM_NAME}}
        return json.dumps(changed, sort_keys=True)

    def lumen_file(self, wildcards):
        """The lumen that a state's anatomy step measures, in the arm's folder (see `Inputs.state_lumen`)."""
        folder = f"{self.inputs.results}/cases/{wildcards.case}"
        return self.inputs.state_lumen(wildcards).replace(folder, f"{folder}/{ARM_NAME}", 1)

    def compared_files(self, wildcards):
        """Anatomy and flow files of the states without a CT. The arm's metrics compare its lumens with these states."""
        names = ("{anatomy}/centreline.vtp", "{anatomy}/sections.csv", "{anatomy}/anatomy.json")
        flow = ("flow/{state}/ffr.json", "flow/{state}/pullback.csv")
        return self.inputs.files_of_states(*names, *flow, without=CT_STATES)(wildcards)
