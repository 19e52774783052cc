"""The lumen's geometry after the program `lumen` has measured it: planned devices and a picture of the tree."""
