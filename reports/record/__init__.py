"""The finished study for machines: its numbers in one JSON file, and what lies where as a research object."""
