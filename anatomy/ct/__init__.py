"""Makes a lumen surface with calcium from a CT angiogram."""
