"""Code for the Snakefile besides its rules: the checked configuration of a study, and the files that a rule's code
consists of."""
