"""The anatomy's readers of surfaces and masks read sound files and seeded mutants of them, in one process."""

import os

from fuzz_runs import count_read_files
from surface_corpus import mutants, seeds

MUTANTS = int(os.environ.get("VCI_FUZZ_TARGET_MUTANTS", 400))
SEED = os.environ.get("VCI_FUZZ_SEED", "")


def test_each_format_answers_or_refuses(binary, tmp_path):
    target, files = binary("anatomy_fuzz_surface"), seeds()
    assert count_read_files(target, tmp_path / "seeds", files) == len(files)
    damaged = {f"mutant_{k}": content for k, content in enumerate(mutants(files, MUTANTS, SEED))}
    assert count_read_files(target, tmp_path / "mutants", damaged) < MUTANTS
