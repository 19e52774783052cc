"""Reads the tables of `whatif` on other plans and inputs of a case, draws them, and prepares them for the page."""
