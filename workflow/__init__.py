"""Code behind the rules of the Snakefile: the checked configuration, each rule's inputs, and checks of the results."""

import common  # noqa: F401  before numpy is loaded: makes it round alike on every processor
