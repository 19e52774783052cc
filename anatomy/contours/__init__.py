"""Makes a lumen surface with plaque from intravascular contours (IVUS, OCT)."""
