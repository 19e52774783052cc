"""Types of plaque, as the surfaces' array `plaque_type` holds them (docs/design.md)."""

NONE, FIBROUS, LIPID, CALCIFIED = range(4)
NAMES = {FIBROUS: "fibrous", LIPID: "lipid", CALCIFIED: "calcified"}
