"""Input functions of the rules: a case's files, its states, and its settings as parameters."""

import os
import pathlib
import shlex

from common.documents import config
from common.patient.states import CT_IMAGED_STATES, CT_PRE, STATES, TRUE_STATES, states_of

ANATOMY_STATES = (*STATES, CT_PRE)  # states with an anatomy folder: the values of {state} in the rules
CENTRELINE_OPTIONS = {
    "units": "--centreline-units",
    "line": "--line",
    "proximal_s_mm": "--proximal-s",
    "rotation_deg": "--rotation",
}


class Inputs:
    """Inputs and parameters of the rules, from a `Configuration`. results: the folder of all results.

    `wildcards` are Snakemake's: case, state and others. key: `lumen`, before the procedure, or `post`, after it.
    """

    def __init__(self, configuration, results="results"):
        self.configuration, self.results = configuration, results

    def states(self, case):
        """The states of a case, by its file and settings.

        Synthetic cases may have a reference, with its CT unless that is disabled. `post` exists if the case gives a
        lumen after the real procedure. Radius correction by the stents alone exists if metrics.stent_alone asks for it.
        """
        settings = self.configuration.settings(case)
        has_post = "post" in self.configuration.cases[case]
        has_reference = not has_post and self.has_reference(case)
        # The order is that of the rules' inputs and options, so another order would run rules again.
        kinds = {
            "every": True,
            "reference": has_reference,
            "stent_alone": settings["metrics"]["stent_alone"],
            "ct": has_reference and settings["ct"]["enabled"],
            "post": has_post,
        }
        return tuple(state for cases, present in kinds.items() if present for state in states_of(cases))

    def has_flow(self, case, state):
        """Whether the flow of a state is computed. It is not for `post` if the case compares areas alone."""
        registration = self.configuration.cases[case].get("registration", {"compare": "flow"})
        return state != "post" or registration["compare"] == "flow"

    def states_with_flow(self, case):
        """The states of a case whose flow is computed."""
        return [state for state in self.states(case) if self.has_flow(case, state)]

    def has_reference(self, case):
        """Whether the reference can treat the case: a synthetic one, by one device at a time in one branch.

        A plan that treats all lesions may go into several branches. That is not known before the lumen is measured, so
        such a case has no reference. Neither has one with a device placed by its lesion alone, in a vessel with lesions
        in several branches.
        """
        description = self.configuration.cases[case]
        if description["kind"] != "synthetic":
            return False
        steps = config.listed_steps(description["plan"])
        devices = [device for step in steps for device in step["devices"]]
        lesion_branches = {lesion["branch"] for lesion in description["vessel"].get("lesions", [])}
        branches = {device["branch"] for device in devices if "branch" in device}
        for device in devices:
            if "branch" not in device:
                branches |= lesion_branches if "lesion" in device else {"main"}
        one_at_a_time = all(len(step["devices"]) == 1 for step in steps)
        treats_all = isinstance(description["plan"], dict) and description["plan"]["treat"] == "all"
        return one_at_a_time and len(branches) <= 1 and not treats_all

    def device_files(self, wildcards):
        """The device families that the case's plan can use."""
        return self.configuration.device_files(wildcards.case)

    def lumen_file(self, wildcards, key="lumen"):
        """The file of the lumen before the procedure, or with the key `post` after it.

        It is generated, made from contours or a CT, or the user's own.
        """
        given = self.configuration.cases[wildcards.case].get(key)
        if given and "path" in given:
            return self.configuration.lumen_file(wildcards.case, key)
        folder = "source" if key == "lumen" else "post/source"
        return f"{self.results}/cases/{wildcards.case}/{folder}/lumen.vtp"

    def cap_files(self, wildcards, key="lumen"):
        """The files of the caps that close the user's surface, the inlet's first; empty if none are given."""
        return self.configuration.cap_files(wildcards.case, key)

    def lumen_options(self, wildcards, key="lumen"):
        """Command-line options of `lumen process` for the surface: its units and, where given, its ends and label."""
        given = self.configuration.cases[wildcards.case].get(key, {})
        options = f"--units {given['units'] if 'path' in given else 'mm'}"
        if "inlet_point_mm" in given:
            options += " --inlet " + ",".join(map(str, given["inlet_point_mm"]))
        if "ct" in given:
            for option, point in _ct_ends(given["ct"]):
                options += f" --{option} " + ",".join(map(str, point))
        for point in given.get("outlet_points_mm", ()):
            options += " --outlet " + ",".join(map(str, point))
        for file in self.cap_files(wildcards, key):
            options += f" --cap {shlex.quote(file)}"
        if "tree" in given:
            options += f" --tree {given['tree']}"
        if "ostium_point_mm" in given:
            options += " --ostium " + ",".join(map(str, given["ostium_point_mm"]))
        if given.get("close_others"):
            options += " --close-others"
        for point in given.get("cut_points_mm", ()):
            options += " --cut " + ",".join(map(str, point))
        if "label" in given:
            labels = given["label"]
            options += " --label " + ",".join(map(str, labels if isinstance(labels, list) else [labels]))
        for key in ("extend_inlet_radii", "extend_outlets_radii"):
            if key in given:
                options += f" --{key.removesuffix('_radii').replace('_', '-')} {given[key]}"
        return options

    def cases_from_contours(self, key="lumen"):
        """Names of the cases whose lumen (or `post`) is given by intravascular contours."""
        return [name for name, case in self.configuration.cases.items() if "contours" in case.get(key, {})]

    def cases_from_ct(self, key="lumen"):
        """Names of the cases whose lumen (or `post`) is found in a CT volume of the user's."""
        return [name for name, case in self.configuration.cases.items() if "ct" in case.get(key, {})]

    def ct_files(self, wildcards, key="lumen"):
        """{volume, centreline: path} of a case's CT."""
        return self.configuration.ct_files(wildcards.case, key)

    def ct_options(self, wildcards, key="lumen"):
        """Command-line options of `anatomy ct` for a case's volume and end points."""
        given, files = self.configuration.cases[wildcards.case][key]["ct"], self.ct_files(wildcards, key)
        options = [files["volume"]]
        for option, point in _ct_ends(given):
            options += [f"--{option}", *map(str, point)]
        options += ["--series", given["series"]] if "series" in given else []
        options += ["--stented"] if given.get("stented", key == "post") else []
        options += ["--centreline", files["centreline"]] if "centreline" in files else []
        return shlex.join(options)

    def contour_files(self, wildcards, key="lumen"):
        """{table: file} of a case's contours."""
        return self.configuration.contour_files(wildcards.case, key)

    def contour_options(self, wildcards, key="lumen"):
        """Command-line options of `anatomy contours`: a case's tables, how to read them, where the contours lie."""
        given = self.configuration.cases[wildcards.case][key]
        files, contours = self.configuration.contour_files(wildcards.case, key), given["contours"]
        options = [files.pop("lumen"), "--units", given["units"], "--z-from", contours["z_from"]]
        options += ["--healthy-wall", contours["healthy_wall_mm"]]
        for key in files:
            options += ["--" + key.replace("_", "-"), files[key]]
        if "z_range_mm" in contours:
            options += ["--z-range", *contours["z_range_mm"]]
        for frame in contours.get("drop_frames", ()):
            options += ["--drop-frame", frame]
        line = contours.get("centreline", {})
        for key, option in CENTRELINE_OPTIONS.items():
            if key in line:
                options += [option, line[key]]
        for point in line.get("landmark_points_mm", ()):
            options += ["--landmark-point", *point]
        return shlex.join([*map(str, options), *(["--mirrored"] if line.get("mirrored") else [])])

    @staticmethod
    def for_post(function):
        """`function` of wildcards and key as a function of the wildcards alone, with the key `post`."""

        def answer(wildcards):
            return function(wildcards, "post")

        return answer

    def section(self, key):
        """A function of the wildcards that gives a section of the case's configuration as JSON text.

        Rules take it as a parameter, so that they run again when that section changes, and only then.
        """

        def text(wildcards):
            return self.configuration.section(wildcards.case, key)

        return text

    def setting(self, section, key):
        """A function of the wildcards that gives one resolved setting of the case."""

        def value(wildcards):
            return self.configuration.settings(wildcards.case)[section][key]

        return value

    def anatomy(self, wildcards):
        """The anatomy folder of a state. For `pre` it lies directly in the case's folder."""
        case = f"{self.results}/cases/{wildcards.case}"
        return f"{case}/anatomy" if wildcards.state == "pre" else f"{case}/{wildcards.state}/anatomy"

    def anatomy_files(self, wildcards):
        """The files of a state's anatomy."""
        folder = self.anatomy(wildcards)
        return {
            "lumen": f"{folder}/lumen.vtp",
            "centreline": f"{folder}/centreline.vtp",
            "sections": f"{folder}/sections.csv",
            "anatomy": f"{folder}/anatomy.json",
        }

    def start_files(self, wildcards):
        """Files of the solved flow in the predicted lumen (`vci`), the first guess for a state's flow.

        The result is empty for `vci` itself and for `pre`, which have no such first guess.
        """
        if wildcards.state in ("pre", "vci"):
            return {}
        case = f"{self.results}/cases/{wildcards.case}"
        start = [f"{case}/flow/vci/{name}" for name in ("solution.vtu", "ffr.json")]
        return {"start": start, "start_centreline": f"{case}/vci/anatomy/centreline.vtp"}

    def state_lumen(self, wildcards):
        """The lumen that a state's anatomy step measures.

        For `ct` it was found in the CT of the reference, for `ct_pre` in the CT before the procedure. For `post` it was
        registered to the frame of the lumen before the procedure.
        """
        folder = {"ct": "ct/reference", "ct_pre": "ct/pre"}.get(wildcards.state, wildcards.state)
        return f"{self.results}/cases/{wildcards.case}/{folder}/lumen.vtp"

    def end_names_file(self, wildcards):
        """The file that names a lumen's ends: the anatomy before the procedure, or for `post` the registration."""
        case = f"{self.results}/cases/{wildcards.case}"
        return f"{case}/post/like.json" if wildcards.state == "post" else f"{case}/anatomy/anatomy.json"

    def registration_files(self, wildcards):
        """The registration of a case's lumen after the real procedure; empty if there is no such lumen."""
        has_post = "post" in self.states(wildcards.case)
        return [f"{self.results}/cases/{wildcards.case}/post/registration.json"] if has_post else []

    def phantom_inputs(self, wildcards):
        """Inputs of a state's simulated CT: its lumen; after the procedure also the stents' plan and the centreline."""
        case = f"{self.results}/cases/{wildcards.case}"
        if wildcards.state == "pre":
            return {"lumen": f"{case}/anatomy/lumen.vtp"}
        return {
            "lumen": f"{case}/reference/lumen.vtp",
            "scene": f"{case}/vci/plan.json",
            "centreline": f"{case}/reference/anatomy/centreline.vtp",
        }

    def segmentation_files(self, wildcards):
        """Records (JSON) of how a case's lumens were made from CT volumes or contours; empty for other cases."""
        case = f"{self.results}/cases/{wildcards.case}"
        if wildcards.case in self.cases_from_ct():
            return [f"{case}/source/segmentation.json"]
        if wildcards.case in self.cases_from_contours():
            return [f"{case}/source/contours.json"]
        states = CT_IMAGED_STATES if "ct" in self.states(wildcards.case) else ()
        return [f"{case}/ct/{state}/segmentation.json" for state in states]

    def end_points_file(self, wildcards):
        """The file with the vessel's end points, which a reader of the image would click: the state's own anatomy."""
        return self.anatomy_files(wildcards)["anatomy"]

    def files_of_states(self, *names, without=()):
        """A function of the wildcards that gives <case>/<name> of every state, with {state} and {anatomy} filled in.

        Names of flow files are left out for states without a computed flow.
        """

        def files(wildcards):
            case = f"{self.results}/cases/{wildcards.case}"
            found = []
            for state in (state for state in self.states(wildcards.case) if state not in without):
                anatomy = "anatomy" if state == "pre" else f"{state}/anatomy"
                wanted = [name for name in names if self.has_flow(wildcards.case, state) or "flow/" not in name]
                found += [f"{case}/" + name.format(state=state, anatomy=anatomy) for name in wanted]
            return found

        return files

    def any_truth(self, cases):
        """Whether any of the cases has data to compare with: a reference, a lumen after PCI or a measured FFR."""
        known = self.configuration.cases
        return self.any_lumen_after(cases) or any("measured" in known[case] for case in cases)

    def any_lumen_after(self, cases):
        """Whether a case has a true lumen after PCI (`reference` or `post`) to compare predictions with."""
        return any(set(TRUE_STATES) & set(self.states(case)) for case in cases)

    def page_templates(self):
        """The files of the report's pages that are not Python: HTML templates, style and scripts."""
        return sorted(str(file) for file in pathlib.Path("reports/page/templates").rglob("*") if file.is_file())


def _ct_ends(given):
    """[(option, point)] of the end points in a CT, the inlet first. option: its name on command lines."""
    return [("inlet", given["inlet_mm"]), *(("outlet", point) for point in given["outlets_mm"])]


def test_results():
    """Results of `make test`, for the report's evidence table; empty if the tests have not been run."""
    return sorted(str(file) for file in pathlib.Path("results/tests").glob("*.xml"))


def procedure_sensitivity_tables(cases):
    """Files that the rule `procedure_sensitivity` made for the cases. Why absolute paths: see `benchmark_tables`."""
    folders = [pathlib.Path(f"results/cases/{case}/sensitivity").absolute() for case in cases]
    return sorted(str(file) for folder in folders for file in folder.glob("deployment*.csv"))


def solved_plans(cases):
    """FFR files that the rule `plan_solve` made for the cases. Why absolute paths: see `benchmark_tables`."""
    folders = [pathlib.Path(f"results/cases/{case}/plans").absolute() for case in cases]
    return sorted(str(file) for folder in folders for file in folder.glob("*/flow/ffr.json"))


def benchmark_tables():
    """Results of `snakemake benchmarks`, for the report; empty if none was run.

    The paths are absolute, so that Snakemake does not see them as outputs of rules. Otherwise, after a change of their
    code, a report would run hours of benchmarks anew.
    """
    found = pathlib.Path("results/benchmarks").absolute()
    return sorted(str(file) for kind in ("csv", "png", "svg") for file in found.glob(f"*/*.{kind}"))


def benchmark_folder(wildcards, input):
    """Command-line option of `reports report` for the folder of the benchmarks; empty if none was run."""
    return f"--benchmarks {os.path.dirname(os.path.dirname(input.benchmarks[0]))}" if input.benchmarks else ""


def programs_folder(wildcards, input):
    """Folder of the compiled programs that a rule runs."""
    return os.path.dirname(input.programs[0])


def output_folder(wildcards, output):
    """Folder of a rule's (first) output, for commands that write several files."""
    return os.path.dirname(output[0])


def frames_option(wildcards, output):
    """Command-line option of `vci deploy` to write lumen and devices after each stage; empty without `frames`."""
    return f"--frames {output.frames}" if "frames" in output.keys() else ""


def start_option(wildcards, input):
    """Command-line option of `flow solve` that names the solved state used as first guess; empty without one."""
    if "start" not in input.keys():
        return ""
    return f"--start {os.path.dirname(input.start[0])} {input.start_centreline}"


def anatomy_folder(wildcards, input):
    """Folder of the anatomy whose files a rule reads."""
    return os.path.dirname(input.get("lumen") or input.anatomy)


def case_folder(wildcards, input):
    """Folder of the case whose metrics or scene a rule reads."""
    return os.path.dirname(input.metrics if "metrics" in input.keys() else os.path.dirname(input.scene))


def stent_options(wildcards, input):
    """Command-line options of `data_synthetic phantom` for the stents; empty before the procedure."""
    return f"--scene {input.scene} --centreline {input.centreline}" if "scene" in input.keys() else ""


def stented_option(wildcards):
    """Command-line option of `anatomy ct` for a state's CT. After the procedure the vessel holds a stent."""
    return "--stented" if wildcards.state == "reference" else ""


def failed_option(wildcards, input):
    """Command-line option of `reports` for the cases that failed; empty if none failed."""
    return f"--failed {input.failed}" if input.failed else ""


def cohort_option(cohort, cases):
    """Command-line option of `reports report` for the cohort's name; empty if single cases were chosen."""
    return "" if cases else f"--cohort {shlex.quote(cohort)}"


def study_folder(wildcards, input):
    """Folder of the study's tables."""
    return os.path.dirname(input.tables[0])


def figures_folder(wildcards, input):
    """Folder of the figures."""
    return os.path.dirname(input.figures[0])
