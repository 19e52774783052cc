"""CT angiogram of a known lumen, and the lumen found in it again."""
