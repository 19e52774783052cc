"""A small study in a folder of its own, which faults are done to: its runs, and whether its products are right."""

import os
import pathlib
import shutil
import signal
import subprocess
import sys
import time

ROOT = pathlib.Path(__file__).resolve().parents[2]
sys.path[:0] = [str(ROOT), str(ROOT / "tests" / "support")]

from places import build_folder  # noqa: E402
from workflow.manifest import product_digest  # noqa: E402

CASE = "quick_focal"
COARSE_SETTINGS = "\n  flow: {ffr_tolerance: 0.1}\n  ct: {enabled: false}\n"  # one mesh, a flow of seconds
STEPS = ("vci/deployment.json", "rc/deployment.json", "flow/vci/ffr.json", "anatomy/tree.png")
TARGETS = [f"results/cases/{CASE}/{step}" for step in STEPS]
LOCK_MESSAGE = "the folder is locked"


class Study:
    """A copy of the repository in `folder`, whose one case runs to a deployment and a flow in three dimensions."""

    def __init__(self, folder):
        self.folder = pathlib.Path(folder)
        listing = subprocess.run(["git", "ls-files"], cwd=ROOT, capture_output=True, text=True, check=True).stdout
        for name in listing.splitlines():
            (self.folder / name).parent.mkdir(parents=True, exist_ok=True)
            shutil.copy2(ROOT / name, self.folder / name)
        (self.folder / "build").symlink_to(build_folder().resolve())
        with open(self.folder / "config" / "cases" / f"{CASE}.yaml", "a") as stream:
            stream.write(COARSE_SETTINGS)

    def start(self, before=(), log="run.log"):
        """Starts the run in a process group of its own -> subprocess.Popen; its output is beside the folder.

        before: a command that runs it.
        """
        command = [*before, "/usr/bin/snakemake", "--profile", "config/profiles/local", "--cores", "1", "--nocolor"]
        self.output = self.folder.parent / f"{self.folder.name}-{log}"
        variables = {**os.environ, "OMP_NUM_THREADS": "1"}
        with open(self.output, "w") as stream:
            return subprocess.Popen(
                [*command, *TARGETS],
                cwd=self.folder,
                env=variables,
                stdout=stream,
                stderr=stream,
                start_new_session=True,
            )

    def run(self, **options):
        """Runs to the end -> exit code."""
        return self.start(**options).wait()

    def kill(self, process, number=signal.SIGKILL):
        """Sends a signal to the run and all its children, and waits until none is left."""
        try:
            os.killpg(process.pid, number)
        except ProcessLookupError:
            pass
        process.wait()
        while _alive(process.pid):
            time.sleep(0.1)

    def unlock(self):
        """What `make unlock` does."""
        subprocess.run(["/usr/bin/snakemake", "--unlock", "--cores", "1"], cwd=self.folder, capture_output=True)

    def output_line(self, *words):
        """The first line of the last run's output that holds one of the words, short; empty where there is none."""
        lines = [line.strip(" |") for line in self.output.read_text(errors="replace").splitlines()]
        found = [line for word in words for line in lines if word.lower() in line.lower()]
        return found[0][:120] if found else ""

    def products(self):
        """{path below results/: digest} of all products that stand at their final names."""
        cases = self.folder / "results" / "cases"
        files = sorted(file for file in cases.rglob("*") if file.is_file() and not file.name.startswith("."))
        kept = [file for file in files if not {"logs", "benchmarks"} & set(file.relative_to(cases).parts)]
        return {str(file.relative_to(cases)): _digest(file) for file in kept}

    def result_bytes(self):
        """Size of all that the run left in results/."""
        return sum(file.stat().st_size for file in (self.folder / "results").rglob("*") if file.is_file())

    def remove_results(self):
        """Removes all that the run left."""
        for name in ("results", ".snakemake"):
            shutil.rmtree(self.folder / name)


def differing_products(found, right):
    """Names of the products that are not as in the undisturbed run; those that are not there yet do not count."""
    return sorted(name for name, value in found.items() if right.get(name) != value)


def _digest(file):
    try:
        return product_digest(file)
    except Exception:  # a JSON file that is not whole is what is looked for
        return "not readable"


def _alive(group):
    try:
        os.killpg(group, 0)
    except ProcessLookupError:
        return False
    return True
