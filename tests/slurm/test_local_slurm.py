"""The Slurm profile on two local nodes: same bits as a local run, too little memory, Ctrl-C, a node that dies.

The steps are those of a small workflow. Its rules have names of the study's rules, so that the profile's groups apply.
One test runs a few steps of the study itself.
"""

import hashlib
import os
import pathlib
import shutil
import signal
import subprocess
import time

import pytest

from places import ROOT, build_folder

PROFILE = ["--profile", str(ROOT / "config" / "profiles" / "slurm"), "--latency-wait", "5"]
SMALL_WORKFLOW = """
rule all:
    input: "cohort"
rule generate:
    output: "{case}/lumen"
    shell: "echo {wildcards.case} >{output}"
rule anatomy:
    input: "{case}/lumen"
    output: "{case}/sections"
    shell: "md5sum <{input} >{output}"
rule flow_solve:
    input: "{case}/sections"
    output: "{case}/ffr"
    shell: "md5sum <{input} >{output}"
rule metrics:
    input: "{case}/sections", "{case}/ffr"
    output: "{case}/metrics"
    shell: "cat {input} >{output}"
rule cohort:
    input: expand("{case}/metrics", case=["lad", "rca"])
    output: "cohort"
    shell: "cat {input} >{output}"
rule hungry:
    output: "hungry"
    shell: "/usr/bin/python3 -c 'import time; held = b\\"x\\" * 2_200_000_000; time.sleep(25)' && echo fed >{output}"
rule slow:
    output: "slow{n}"
    shell: "echo {wildcards.n} >{output}; sleep 600"
rule node_of_a_rule:
    output: "node"
    shell: "echo half >{output}; [ -e second ] || {{ touch second; sleep 600; }}; echo whole >{output}"
"""

pytestmark = [
    pytest.mark.long,
    pytest.mark.skipif(os.geteuid() != 0, reason="a Slurm of one's own needs root"),
    pytest.mark.skipif(
        not all(
            shutil.which(name, path=os.environ["PATH"] + ":/usr/sbin") for name in ("munged", "slurmctld", "slurmd")
        ),
        reason="Slurm is missing: apt-get install slurmctld slurmd slurm-client munge",
    ),
]


class Cluster:
    """Runs commands in the environment of a local Slurm."""

    def __init__(self, environment):
        self.environment = environment

    def slurm_command(self, *command):
        """What a command of Slurm prints."""
        return subprocess.run(command, env=self.environment, text=True, capture_output=True, timeout=60).stdout

    def start(self, folder, *arguments):
        """Starts Snakemake with the profile in `folder`; returns the Popen."""
        command = ["/usr/bin/snakemake", *PROFILE, *arguments]
        with open(folder / "log", "w") as log:
            return subprocess.Popen(command, cwd=folder, env=self.environment, stdout=log, stderr=log)

    def run(self, folder, *arguments):
        """Runs Snakemake to its end, which must be a success; returns the logs of its jobs, the first job first."""
        assert self.start(folder, *arguments).wait(timeout=900) == 0, (folder / "log").read_text()
        return [file.read_text() for file in sorted((folder / ".snakemake" / "slurm").glob("*.log"))]

    def running(self, count):
        """[(job, node)] as soon as `count` jobs run."""
        for _ in range(240):
            lines = self.slurm_command("squeue", "--noheader", "--states=RUNNING", "--format=%i %N").splitlines()
            if len(lines) == count:
                return [tuple(line.split()) for line in lines]
            time.sleep(0.5)
        raise AssertionError(f"{count} jobs never ran: {self.slurm_command('squeue')}")

    def kill_node(self, job, node):
        """As a power cut: kills the daemon of a node and all processes of the job, and does not tell the controller."""
        folder = self.environment["VCI_SLURM_FOLDER"]
        os.kill(int(pathlib.Path(folder, f"{node}.pid").read_text()), signal.SIGKILL)
        ours = [
            process for process in pathlib.Path("/proc").glob("[0-9]*") if f"{folder}/" in _read(process / "environ")
        ]
        step = [process for process in ours if _read(process / "cmdline").startswith(f"slurmstepd: [{job}.")]
        assert step, "the job's own daemon is not found"
        for process in step + [one for one in ours if f"SLURM_JOB_ID={job}\0" in _read(one / "environ")]:
            os.kill(int(process.name), signal.SIGKILL)


def _read(path):
    """Text of a file of /proc; empty if its process is gone."""
    try:
        return path.read_text(errors="replace")
    except OSError:
        return ""


@pytest.fixture(scope="module", params=[None, "study"], ids=["without accounts", "with accounts"])
def cluster(request, tmp_path_factory):
    """A Slurm of two nodes: once without accounting, once with slurmdbd and MariaDB."""
    if request.param and not (
        shutil.which("mariadbd") and shutil.which("slurmdbd", path=os.environ["PATH"] + ":/usr/sbin")
    ):
        pytest.skip("accounting is missing: apt-get install slurmdbd mariadb-server")
    said = tmp_path_factory.mktemp("cluster") / "environment"
    variables = {**os.environ, **({"VCI_SLURM_ACCOUNT": request.param} if request.param else {})}
    command = [
        ROOT / "tests" / "slurm" / "local_slurm.sh",
        "sh",
        "-c",
        'env -0 >"$0.part"; mv "$0.part" "$0"; read _',
        said,
    ]
    process = subprocess.Popen(command, env=variables, stdin=subprocess.PIPE)
    try:
        for _ in range(600):
            if said.exists() or process.poll() is not None:
                break
            time.sleep(0.2)
        assert said.exists(), "the local Slurm did not come up"
        pairs = [line.partition("=") for line in said.read_text().split("\0") if line]
        yield Cluster({name: value for name, _, value in pairs})
    finally:
        process.stdin.close()
        process.wait(timeout=120)


@pytest.fixture
def small(tmp_path):
    """A folder with the small workflow."""
    (tmp_path / "Snakefile").write_text(SMALL_WORKFLOW)
    return tmp_path


def test_groups_give_the_same_bits_as_a_local_run(cluster, small):
    """Nine steps are seven jobs: for each case the steps before the flow, the flow and the metrics; then the cohort."""
    assert len(cluster.run(small)) == 7
    through_slurm = (small / "cohort").read_bytes()
    (small / "cohort").unlink()
    subprocess.run(["/usr/bin/snakemake", "--cores", "1", "--forceall"], cwd=small, check=True, capture_output=True)
    assert (small / "cohort").read_bytes() == through_slurm


def test_a_job_without_enough_memory_gets_twice_as_much(cluster, small):
    first, second = cluster.run(small, "hungry")
    assert "memory limit" in first and "memory limit" not in second
    assert (small / "hungry").read_text() == "fed\n"


def test_ctrl_c_leaves_no_job(cluster, small):
    snakemake = cluster.start(small, "slow1", "slow2", "slow3")
    cluster.running(2)
    snakemake.send_signal(signal.SIGINT)
    assert snakemake.wait(timeout=60) != 0
    for _ in range(60):
        left = cluster.slurm_command("squeue", "--noheader")
        if not left:
            break
        time.sleep(0.5)
    assert left == ""


@pytest.mark.skipif(not (build_folder() / "lumen").is_file(), reason="the programs are not built: make build")
def test_steps_of_the_study(cluster, tmp_path):
    """A small case up to its radius correction, in one job."""
    targets = [f"results/cases/quick_focal/{name}" for name in ("vci/plan.json", "rc/anatomy/sections.csv")]
    hashes = []
    for place in ("here", "slurm"):
        folder = tmp_path / place
        subprocess.run(["git", "checkout-index", "--all", f"--prefix={folder}/"], cwd=ROOT, check=True)
        (folder / "build").symlink_to(build_folder().resolve())
        if place == "slurm":
            assert len(cluster.run(folder, *targets, "--config", "cohort=quick")) == 1
        else:
            command = ["/usr/bin/snakemake", "--cores", "1", *targets, "--config", "cohort=quick"]
            subprocess.run(command, cwd=folder, check=True, capture_output=True)
        hashes.append([hashlib.sha256((folder / target).read_bytes()).hexdigest() for target in targets])
    assert hashes[0] == hashes[1]


def test_a_node_that_dies(cluster, small):
    """The job of a dead node runs again on the other node. The test comes last because the node stays dead."""
    snakemake = cluster.start(small, "node")
    [(job, node)] = cluster.running(1)
    while not (small / "second").exists():
        time.sleep(0.2)
    cluster.kill_node(job, node)
    assert snakemake.wait(timeout=300) == 0, (small / "log").read_text()
    assert "NODE_FAIL" in cluster.slurm_command("scontrol", "show", "job", job)
    assert (small / "node").read_text() == "whole\n"
    assert len(list((small / ".snakemake" / "slurm").glob("*.log"))) == 2
