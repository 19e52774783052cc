"""CT angiograms in, lumen surface with calcium out."""
