"""Virtual patients with a known truth, and their lumen after PCI by an independent method."""

import common  # noqa: F401  chooses functions that round alike on every processor, before numpy is loaded
