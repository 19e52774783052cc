"""What if: other plans for a case, and other values of its uncertain inputs, by the engine and a reduced flow.

May import: common.*, anatomy, anatomy.planning, flow.*.
"""

import common  # noqa: F401  chooses functions that round alike on every processor, before numpy is loaded
