"""The finished study for machines: its numbers in one JSON file, and a list of its files as a research object."""
