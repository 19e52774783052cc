"""The whole configuration of a study, checked before any step runs; the rules read parts from it."""

import json
import os
import pathlib
import re

from anatomy.contours import reading as contours
from common.documents import config, schema, yaml_reader
from common.errors import InputError
from data_synthetic import patient
from flow.settings import check_meshes, check_switches

COARSE_MESHES = ("mesh_coarsest.msh", "mesh_coarse.msh")  # in the order of the flow's setting `coarse_rings`
CASE_NAME = "[a-z][a-z0-9_]*"


class Configuration:
    """Study, device families and cases of a folder like config/; raises InputError for anything that is not allowed.

    folder: holds study.yaml, devices/ and cases/. data_folder: takes the place of data/ at the
    beginning of a case's paths. leave_out_bad_cases: a case whose file is not allowed goes to `refused`, {name: error};
    selected_cases() raises the error if that case is to run.
    """

    def __init__(self, folder="config", data_folder=None, leave_out_bad_cases=False):
        self.folder = pathlib.Path(folder)
        self.data_folder = pathlib.Path(data_folder or os.environ.get("VCI_DATA_DIR") or "data")
        self.study = config.load_study(self.folder / "study.yaml")
        self.devices = config.load_devices(self.folder / "devices")
        for file in sorted(self.folder.glob("devices/*.yml")):
            _check_ending(file)
        self.cases, self.refused, self._valid_sections = {}, {}, set()
        for file in sorted([*self.folder.glob("cases/*.yaml"), *self.folder.glob("cases/*.yml")]):
            try:
                self._add_case(file)
            except InputError as error:
                if not leave_out_bad_cases:
                    raise
                self.cases.pop(file.stem, None)
                self.refused[file.stem] = error
        self._check_cohorts()

    def cases_of_kind(self, kind):
        """Names of the cases that are `synthetic` or `surface`."""
        return [name for name, case in self.cases.items() if case["kind"] == kind]

    def cases_with_key(self, key):
        """Names of the cases whose file has a key."""
        return [name for name, case in self.cases.items() if key in case]

    def case_file(self, name):
        """Path of a case's file, such as config/cases/<name>.yaml."""
        return self.folder / "cases" / f"{name}.yaml"

    def device_files(self, name):
        """Files of the device families that a case's plan can use: those it names, or all if it is to be proposed."""
        steps = config.listed_steps(self.cases[name]["plan"])
        if not steps:
            families = set(self.devices)
        else:
            families = {device["device"] for step in steps for device in step["devices"]}
            families |= {
                self.devices[name]["delivery_balloon"] for name in families if self.devices[name]["kind"] == "stent"
            }
        return [str(self.folder / "devices" / f"{family}.yaml") for family in sorted(families)]

    def section(self, name, key):
        """A section of a case's settings, or another part such as vessel or plan, as JSON text with sorted keys."""
        value = self.settings(name)[key] if key in config.SECTIONS else self.cases[name].get(key)
        return json.dumps(value, sort_keys=True)

    def settings(self, name):
        """{section: values}: the settings of a case, from the study and the case's own file."""
        return config.resolve_settings(self.study, self.cases[name])

    def lumen_file(self, name, key="lumen"):
        """The surface file of a case's `lumen` or `post`. For a missing file InputError says where to put it."""
        return self._data_file(name, "lumen surface", f"{key}.path", self.cases[name][key]["path"])

    def cap_files(self, name, key="lumen"):
        """The files of the ends' caps, the inlet's first; empty if the case gives none. A missing one: InputError."""
        caps = self.cases[name].get(key, {}).get("caps")
        if not caps:
            return []
        found = [self._data_file(name, "cap", f"{key}.caps.inlet", caps["inlet"])]
        return found + [self._data_file(name, "cap", f"{key}.caps.outlets", path) for path in caps["outlets"]]

    def ct_files(self, name, key="lumen"):
        """{volume, centreline: path} of the CT that a case gives as `lumen` or `post`; {} if it gives no CT."""
        given = self.cases[name].get(key, {}).get("ct", {})
        entries = {"volume": "path", "centreline": "centreline"}
        return {
            role: self._data_file(name, "CT volume" if role == "volume" else role, f"{key}.ct.{entry}", given[entry])
            for role, entry in entries.items()
            if entry in given
        }

    def contour_files(self, name, key="lumen"):
        """{table: file} of the contours that a case gives as `lumen` or `post`, and of their centreline; {} if none."""
        given = self.cases[name].get(key, {}).get("contours", {})
        found = {
            table: self._data_file(name, "contour table", f"{key}.contours.{table}", given[table])
            for table in contours.TABLES
            if table in given
        }
        if "centreline" in given:
            where = f"{key}.contours.centreline.path"
            found["centreline"] = self._data_file(name, "centreline", where, given["centreline"]["path"])
        return found

    def _data_file(self, name, what, key, path):
        """The file that a path in a case's file means. For a missing file InputError says where to put it.

        what: the file in words. key: key of the path in the case's file. Both stand in the message.
        """
        given = pathlib.Path(path)
        file = self.data_folder / given.relative_to("data") if given.parts[0] == "data" else given
        if not file.exists():
            remedy = f"put it there (the case file says whence), or set VCI_DATA_DIR to the folder of {given.name}"
            raise InputError(f"{what} not found", f"{self.case_file(name)}, key {key}", file, remedy)
        return str(file)

    def selected_cases(self, cohort, cases=None):
        """Names of the cases to run: `cases` ("a b" or "a,b") if given, else the cohort's.

        Raises InputError for an unknown cohort or case, for a refused case, and for a case whose files are missing.
        """
        cohorts = self.study["cohorts"]
        if cases:
            names = [name for name in re.split(r"[\s,]+", str(cases)) if name]
            where = "CASES (or --config cases=)"
        elif cohort in cohorts:
            names, where = cohorts[cohort], f"cohort {cohort}"
        else:
            raise InputError("no such cohort", "COHORT (or --config cohort=)", cohort, f"one of {', '.join(cohorts)}")
        for name in names:
            if name in self.refused:
                raise self.refused[name]
            if name not in self.cases:
                raise InputError("no such case", where, name, f"one of {', '.join(self.cases)}")
            for key in ("lumen", "post"):
                if key in self.cases[name] and not self.contour_files(name, key) and not self.ct_files(name, key):
                    self.lumen_file(name, key)
                self.cap_files(name, key)
        return list(dict.fromkeys(names))

    def _add_case(self, file):
        _check_ending(file)
        name = _case_name(file)
        case = self.cases[name] = config.load_case(file)
        self._check_plan(name, case)
        self._check_settings(name)
        if case["kind"] == "synthetic":
            patient.check(case["vessel"], str(file))

    def _check_cohorts(self):
        document = yaml_reader.read(self.folder / "study.yaml")
        for cohort, names in self.study["cohorts"].items():
            for i, name in enumerate(names):
                if name not in self.cases and name not in self.refused:
                    where = document.where(("cohorts", cohort, i))
                    raise InputError("no such case", where, name, f"known cases: {', '.join(self.cases)}")

    def _check_plan(self, name, case):
        if not config.listed_steps(case["plan"]):
            return
        document = yaml_reader.read(self.case_file(name))
        for i, step in enumerate(config.listed_steps(case["plan"])):
            for j, device in enumerate(step["devices"]):
                self._check_device(document, ("plan", i, "devices", j), step["action"], device)

    def _check_device(self, document, path, action, device):
        def refuse(key, what, remedy):
            raise InputError(what, document.where(path + (key,)), device[key], remedy)

        kind = "stent" if action == "stent" else "balloon"
        family = self.devices.get(device["device"], {})
        if family.get("kind") != kind:
            known = ", ".join(key for key, value in self.devices.items() if value["kind"] == kind)
            refuse("device", f"no such {kind}", f"for a step {action}: {known}")
        for key, sizes in (("diameter_mm", "diameters_mm"), ("length_mm", "lengths_mm")):
            if device[key] not in family[sizes]:
                refuse(key, "size that the family does not have", f"one of {', '.join(map(str, family[sizes]))}")
        limit = self.devices[config.balloon_family(self.devices, device["device"])]["rated_burst_pressure_bar"]
        if device["pressure_bar"] > limit:
            refuse("pressure_bar", "above the rated burst pressure", f"at most {limit} bar")

    def _check_settings(self, name):
        """Checks each case's sections after merging, since a case may change one of two keys that must fit together.

        A section equal to a checked one is not checked again. In a cohort of drawn patients most are equal.
        """
        for section, values in self.settings(name).items():
            text = f"{section} {json.dumps(values, sort_keys=True)}"
            if text in self._valid_sections:
                continue
            self._valid_sections.add(text)
            document = yaml_reader.Document(self.case_file(name), values, {(): 1})
            schema.validate(document, schema.read(section))
            if section == "flow":
                check_meshes(values, self.case_file(name))
                if len(values["coarse_rings"]) != len(COARSE_MESHES):
                    where = f"{self.case_file(name)}: coarse_rings"
                    remedy = f"give {len(COARSE_MESHES)}, the least first"
                    raise InputError("a study makes two coarser meshes", where, values["coarse_rings"], remedy)
                check_switches(values, self.case_file(name))


def _check_ending(file):
    if file.suffix != ".yaml":
        raise InputError("ending that is not read", file, file.suffix, f"rename it {file.stem}.yaml")


def _case_name(file):
    """The case's name, from the name of its file. Raises InputError if folders, cohorts or rules cannot use it."""
    if not re.fullmatch(CASE_NAME, file.stem):
        remedy = "rename it: a small letter, then small letters, digits and underscores"
        raise InputError("name that a case cannot have", file, file.stem, remedy)
    return file.stem
