"""What the Snakefile needs besides rules: the checked configuration of a study, and what code a rule depends on."""
