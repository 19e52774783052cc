"""Compiled forms, for every part that uses FEniCSx: its name of the compiler's options changes with the version."""

from dolfinx import fem

# two programs that start together compile the same forms: one waits for the other, by default for 10 s only
WAIT_S = 300


def form(expression, flags=()):
    """Compiled form of a UFL expression; flags: of the C compiler, in place of FEniCSx's own."""
    options = {"timeout": WAIT_S}
    if flags:
        options["cffi_extra_compile_args"] = list(flags)
    return fem.form(expression, jit_params=options)
