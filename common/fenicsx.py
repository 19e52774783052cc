"""Compiled forms, for every part that uses FEniCSx: its name of the compiler's options changes with the version."""

import pathlib
import time

from dolfinx import fem, jit

# two programs that start together compile the same forms: one waits for the other, by default for 10 s only
WAIT_S = 300


def form(expression, flags=()):
    """Compiled form of a UFL expression; flags: of the C compiler, in place of FEniCSx's own."""
    options = {"timeout": WAIT_S}
    if flags:
        options["cffi_extra_compile_args"] = list(flags)
    return fem.form(expression, jit_params=options)


def drop_unfinished():
    """Removes files that killed programs left in FEniCSx's compilation cache; returns the files' names.

    Such a source file tells every later program that somebody is compiling. That program would wait, and then fail.
    Only files older than WAIT_S are removed; no form takes that long.
    """
    dropped = []
    for source in pathlib.Path(jit.get_parameters()["cache_dir"]).expanduser().glob("libffcx_*.c"):
        try:
            if not source.with_suffix(".c.cached").exists() and time.time() - source.stat().st_mtime > WAIT_S:
                source.unlink()
                dropped.append(source.name)
        except FileNotFoundError:  # another program was faster
            continue
    return dropped


drop_unfinished()  # before the first function space, which compiles too
