"""Virtual patients with a known truth, and their lumen after PCI by an independent method.

May import: common.*.
"""

import common  # noqa: F401  must precede numpy: it limits numpy to code that rounds alike on every processor
