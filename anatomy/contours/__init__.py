"""Intravascular contours (IVUS, OCT) in, lumen surface with plaque out."""
