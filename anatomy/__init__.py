"""Steps before and after the program `lumen`: lumens from CT and contours, registration, planned devices, pictures."""

import common  # noqa: F401  chooses functions that round alike on every processor, before numpy is loaded
