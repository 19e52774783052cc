"""Running a fuzz target that was built without libFuzzer over files."""

import re
import subprocess

TIMEOUT_S = 120  # of a target over all its files; under the sanitizers some ten


def count_read_files(target, folder, contents):
    """How many of the files {name: bytes} a target reads; it refuses the others. Any other exception, a crash, a
    sanitizer's report, a leak, or five seconds over one file fail."""
    folder.mkdir()
    for name, content in contents.items():
        (folder / name).write_bytes(content)
    command = [str(target), *(str(folder / name) for name in sorted(contents))]
    result = subprocess.run(command, text=True, errors="replace", capture_output=True, timeout=TIMEOUT_S)
    assert result.returncode == 0, result.stderr[-3000:]
    files, read = re.fullmatch(r"(\d+) files, (\d+) read, 0 failed\n", result.stdout).groups()
    assert int(files) == len(contents)
    return int(read)
