"""One case measured: the treated segment, its area, curvature and FFR in each state -> metrics.json.

May import: common.*, reports.inputs.
"""
