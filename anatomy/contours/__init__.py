"""Makes a lumen surface with plaque from intravascular contours (IVUS, OCT).

May import: common.*, anatomy, anatomy.contours.reading.
"""
