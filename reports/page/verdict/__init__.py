"""The verdict at the head of the page: what the study found, in a few sentences made from its own tables."""
