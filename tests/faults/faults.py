"""The faults: each is done to a study, which then resumes. Each returns a row {fault, ...} of what was seen."""

import contextlib
import os
import pathlib
import signal
import subprocess
import sys
import tempfile
import time

from study import LOCK_MESSAGE, differing_products

TEMPORARY = tempfile.gettempdir()
FULL_TMP = (
    f"mount -t tmpfs -o size=64k none {TEMPORARY} && {{ dd if=/dev/zero of={TEMPORARY}/full bs=1k 2>/dev/null; "
    'python3 -c "import tempfile; tempfile.gettempdir()" 2>/dev/null; exec "$@"; }'
)
POLL_S = 0.05


def wait_for(study, process, text, times=1):
    """Waits until the run's output holds a text so many times, or it has ended."""
    while process.poll() is None and study.output.read_text().count(text) < times:
        time.sleep(POLL_S)


def resume_and_compare(study, right, row, code, **options):
    """The row completed: what was said, what stands at final names, and what the run gives that goes on."""
    row |= {"exit_code": code, "half_made": differing_products(study.products(), right)}
    study.unlock()
    row["resumed_exit_code"] = study.run(**options)
    found = study.products()
    row |= {"differ": sorted({*differing_products(found, right), *(set(right) - set(found))}), "products": len(found)}
    return row


def kills(study, right, seconds, count, random):
    """SIGKILL to all processes of the run, at moments drawn from its first step on; it goes on after each kill."""
    rows = []
    while len(rows) < count:
        process = study.start()
        wait_for(study, process, "Job ")
        moment = random.uniform(0, 0.3 * seconds)
        end = time.monotonic() + moment
        while process.poll() is None and time.monotonic() < end:
            time.sleep(POLL_S)
        if process.poll() is not None:  # it ended before: compare, and start anew
            found = differing_products(study.products(), right)
            if process.returncode or found:
                sys.exit(f"a run after kills ended with {process.returncode}, differs in {found}; see {study.output}")
            study.remove_results()
            continue
        step = [line for line in study.output.read_text().splitlines() if line.startswith("Job ")][-1]
        study.kill(process)
        found = differing_products(study.products(), right)
        rows.append(
            {"fault": "SIGKILL", "moment_s": round(moment, 1), "step": step.split(": ", 2)[-1], "half_made": found}
        )
        print(rows[-1], flush=True)
        study.unlock()
    last = resume_and_compare(study, right, rows[-1], -9)
    for row in rows:
        row |= {key: last[key] for key in ("exit_code", "resumed_exit_code", "differ", "products")}
        row["said"] = ""
    return rows


def terminated(study, right, seconds):
    """SIGTERM to Snakemake alone, as a batch system or `kill` sends it."""
    process = study.start()
    wait_for(study, process, "Job ", 4)
    process.terminate()
    code = process.wait()
    row = {"fault": "SIGTERM", "said": study.output_line("terminat", "signal", "shutting")}
    study.kill(process)
    return resume_and_compare(study, right, row, code)


def step_killed(study, right, seconds):
    """SIGKILL to the flow alone, as the kernel does to a process when memory is short."""
    process = study.start()
    flow = None
    while process.poll() is None and flow is None:
        time.sleep(POLL_S)
        flow = _find_child(process.pid, "flow solve")
    if flow is None:
        sys.exit(f"the run ended before its flow: {study.output.read_text()}")
    time.sleep(1)
    os.kill(flow, signal.SIGKILL)
    code = process.wait()
    row = {
        "fault": "out of memory: the flow killed by the kernel",
        "said": study.output_line("exit code 137", "Killed"),
    }
    return resume_and_compare(study, right, row, code)


def memory_limit(study, right, seconds, megabytes=700):
    """A limit of the address space that the deployment keeps within and the volume mesh does not."""
    code = study.run(before=["prlimit", f"--as={megabytes * 1024 * 1024}"])
    words = ("error: ", "MemoryError", "bad_alloc", "Cannot allocate", "failed to map", "exit code")
    row = {"fault": f"address space of {megabytes} MB", "said": study.output_line(*words)}
    return resume_and_compare(study, right, row, code)


def full_tmp(study, right, seconds):
    """The folder of temporary files without a free byte, in a mount namespace of its own."""
    code = study.run(before=["unshare", "-m", "sh", "-c", FULL_TMP, "sh"])
    row = {
        "fault": "the folder of temporary files is full",
        "said": study.output_line("No space left", "no usable temporary", "exit code"),
    }
    return resume_and_compare(study, right, row, code)


def two_runs(study, right, seconds):
    """A second run in the same folder while the first one works."""
    first = study.start()
    wait_for(study, first, "Job ")
    output = study.output
    second = study.start(log="second.log")
    code = second.wait()
    row = {
        "fault": "a second run in the same folder",
        "said": study.output_line("cannot be locked", LOCK_MESSAGE),
        "exit_code": code,
    }
    study.output = output
    row |= {"half_made": [], "resumed_exit_code": first.wait()}
    found = study.products()
    return row | {
        "differ": sorted({*differing_products(found, right), *(set(right) - set(found))}),
        "products": len(found),
    }


def full_disk(study, right, seconds):
    """The disk under the whole folder is full when two thirds of the products are there; then it grows."""
    disk = os.statvfs(study.folder)
    used = (disk.f_blocks - disk.f_bfree) * disk.f_frsize
    mount(study.folder, f"remount,size={used + study.undisturbed_bytes * 2 // 3}")
    code = study.run()
    row = {"fault": "the disk is full", "said": study.output_line("No space left", "error: ", "exit code")}
    mount(study.folder, "remount,size=1g")
    return resume_and_compare(study, right, row, code)


def read_only(study, right, seconds):
    """The folder becomes read-only after the first steps; then it may be written again."""
    process = study.start()
    wait_for(study, process, "Job ", 4)
    study.kill(process)
    study.unlock()
    mount(study.folder, "remount,ro")
    code = study.run()
    row = {"fault": "the folder is read-only", "said": study.output_line("Read-only", "exit code")}
    mount(study.folder, "remount,rw")
    return resume_and_compare(study, right, row, code)


def mount(folder, options):
    """Mounts, or mounts again, a memory file system. Raises CalledProcessError where that is not allowed."""
    subprocess.run(["mount", "-t", "tmpfs", "-o", options, "none", str(folder)], check=True, capture_output=True)


def _find_child(group, words):
    """Process of a group whose command holds the words, and which is no shell; None where there is none."""
    for folder in pathlib.Path("/proc").glob("[0-9]*"):
        with contextlib.suppress(OSError):
            command = (folder / "cmdline").read_bytes().replace(b"\0", b" ").decode(errors="replace")
            if os.getpgid(int(folder.name)) == group and words in command and "run.sh" not in command:
                return int(folder.name)
    return None
