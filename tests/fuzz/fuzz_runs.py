"""Running a fuzz target that was built without libFuzzer over files."""

import re
import subprocess

TIMEOUT_S = 120  # for one target over all its files; with sanitizers it takes about 10 s


def count_read_files(target, folder, contents):
    """The number of the files {name: bytes} that a target reads; it must refuse the others.

    Fails on any other exception, a crash, a report of a sanitizer, a leak, or more than five seconds over one file.
    """
    folder.mkdir()
    for name, content in contents.items():
        (folder / name).write_bytes(content)
    command = [str(target), *(str(folder / name) for name in sorted(contents))]
    result = subprocess.run(command, text=True, errors="replace", capture_output=True, timeout=TIMEOUT_S)
    assert result.returncode == 0, result.stderr[-3000:]
    files, read = re.fullmatch(r"(\d+) files, (\d+) read, 0 failed\n", result.stdout).groups()
    assert int(files) == len(contents)
    return int(read)
