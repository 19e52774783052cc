"""Steps before and after the program `lumen`: lumens from CT and contours, registration, planned devices, pictures."""
