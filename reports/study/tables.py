"""Writing CSV tables."""

from common.files import replacing


def write_csv(path, table):
    """Writes a DataFrame whole or not at all; a missing value becomes an empty field."""
    with replacing(path) as partial:
        table.to_csv(partial, index=False, lineterminator="\n")
