"""One case measured: the stented segment, its area, curvature and FFR in each state -> metrics.json.

It builds on inputs.
"""
