"""The README of each part is short: 400 to 800 words, as `wc -w` counts them. Details have pages of their own."""

LEAST_WORDS, MOST_WORDS = 400, 800


def test_the_readme_of_each_part_has_400_to_800_words(repo_root):
    words = {file.parent.name: len(file.read_text().split()) for file in repo_root.glob("*/README.md")}
    assert {"anatomy", "data_synthetic", "flow", "reports", "vci", "whatif"} <= set(words)
    wrong = {part: count for part, count in words.items() if not LEAST_WORDS <= count <= MOST_WORDS}
    assert not wrong, f"words by part: {wrong}; move details to the part's other pages"
