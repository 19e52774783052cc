"""CT angiogram of a known lumen, and how well the lumen found in it agrees."""
