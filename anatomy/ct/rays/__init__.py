"""Where the lumen ends on a ray from its axis: blood beside wall, beside calcium and beside a stent."""
