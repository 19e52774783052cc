"""Code behind the rules of the Snakefile: the checked configuration, each rule's inputs, and checks of the results."""
