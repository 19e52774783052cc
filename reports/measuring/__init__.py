"""One case measured: the treated segment, its area, curvature and FFR in each state -> metrics.json.

It imports from the folder inputs.
"""
