"""The README of each part is short: 400 to 800 words, as `wc -w` counts them. Details have pages of their own."""

import subprocess

LEAST_WORDS, MOST_WORDS = 400, 800


def test_the_readme_of_each_part_has_400_to_800_words(repo_root):
    """Only files under version control count: tools leave READMEs of their own, such as that of .pytest_cache."""
    listed = subprocess.run(
        ["git", "ls-files", ":(glob)*/README.md"], cwd=repo_root, capture_output=True, text=True, check=True
    )
    words = {name.partition("/")[0]: len((repo_root / name).read_text().split()) for name in listed.stdout.split()}
    assert {"anatomy", "data_synthetic", "flow", "reports", "vci", "whatif"} <= set(words)
    wrong = {part: count for part, count in words.items() if not LEAST_WORDS <= count <= MOST_WORDS}
    assert not wrong, f"words by part: {wrong}; move details to the part's other pages"
