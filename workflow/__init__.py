"""Code behind the rules of the Snakefile: the checked configuration, each rule's inputs, and checks of the results.

May import: common.*, anatomy.contours.reading, data_synthetic, flow, flow.inputs.
"""

import common  # noqa: F401  before numpy is loaded: makes it round alike on every processor
