"""Reads the tables of `whatif` on other plans and other inputs of a case, draws them and puts them into words."""
