"""Writing CSV tables."""

from common.files import replacing


def write_csv(path, table):
    """Writes a DataFrame whole or not at all; what is missing becomes an empty field."""
    with replacing(path) as partial:
        table.to_csv(partial, index=False, lineterminator="\n")
