"""Inputs: boundary values of a patient and the anatomy summary that they follow from."""
