"""Steps before and after the program `lumen`: lumens from CT and contours, registration, planned devices, pictures.

May import: common.*.
"""

import common  # noqa: F401  must precede numpy: it limits numpy to code that rounds alike on every processor
