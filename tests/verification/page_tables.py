"""Tables of a folder's measured.md from the results' files.

A table stands between the lines `<!-- table: NAME -->` and `<!-- end -->`, NAME being the folder of a benchmark; where
nothing of it was run the table stays. Where a part of it was run, a page may keep the other rows (`keys` of Page).
"""

import argparse
import csv
import pathlib
import re
import sys

ROOT = pathlib.Path(__file__).resolve().parents[2]
sys.path[:0] = [str(ROOT)]

from common.errors import InputError, guarded  # noqa: E402

TABLE_MARKS = re.compile(r"(<!-- table: (\w+) -->\n).*?(<!-- end -->)", re.S)


def markdown(headings, rows):
    """A table of rows of strings."""
    return "".join(f"| {' | '.join(line)} |\n" for line in [headings, ["---"] * len(headings), *rows])


def merged(old, new, cells):
    """Markdown of the table `new` with the rows of the table `old` that it lacks. Both are lists of lines.

    Rows are the same if their first `cells` cells are. Rows of `old` keep their order, and further rows come last. Of a
    table with other headings nothing is kept.
    """

    def by_key(lines):
        return {tuple(line.split("|")[1 : cells + 1]): line for line in lines[2:]}

    kept = by_key(old) if old[:1] == new[:1] else {}
    return "".join(f"{line}\n" for line in [*new[:2], *(kept | by_key(new)).values()])


def read_columns(path, columns):
    """The rows (dicts of strings) of a CSV file that must have these columns. Raises InputError if one lacks."""
    with path.open(newline="") as file:
        reader = csv.DictReader(file)
        missing = [name for name in columns if name not in (reader.fieldnames or [])]
        if missing:
            raise InputError("a table lacks columns", path, ", ".join(missing), "run what makes it again")
        return list(reader)


class Page:
    """The measured.md of `folder`, or the page that `folder` names.

    tables: {benchmark: (its table's file, {column there: heading})}; digits: {column: format of its numbers};
    table_functions: {name: function of the folder `results` that gives a table's Markdown, or None where nothing was
    run}; keys: {name of a table whose rows stay unless they were run again: how many cells tell its rows apart}.
    """

    def __init__(self, folder, tables, digits, table_functions=None, keys=None):
        page = ROOT / folder
        self.path = page if page.suffix == ".md" else page / "measured.md"
        self.tables, self.digits, self.table_functions = tables, digits, table_functions or {}
        self.keys = keys or {}

    def text(self, column, value):
        """A value as the page writes it; words stay."""
        try:
            return f"{float(value):{self.digits[column]}}" if column in self.digits else value
        except ValueError:
            return value

    def table(self, path, columns):
        """Markdown of the columns {name in the file: heading} of a CSV file. Raises InputError where one is missing."""
        rows = [[self.text(name, row[name]) for name in columns] for row in read_columns(path, columns)]
        return markdown(list(columns.values()), rows)

    @staticmethod
    def names(text):
        """The set of tables that a page's text has a place for."""
        return {name for _, name, _ in TABLE_MARKS.findall(text)}

    def filled(self, text, results):
        """The page's text with the tables of what was run in the folder `results`. Raises InputError."""

        def replacement(found):
            name, table = found.group(2), None
            if name in self.table_functions:
                table = self.table_functions[name](results)
            elif name in self.tables:
                file, columns = self.tables[name]
                path = results / "benchmarks" / name / file
                table = self.table(path, columns) if path.is_file() else None
            else:
                raise InputError("no such table", self.path, name, ", ".join([*self.tables, *self.table_functions]))
            if table is None:
                return found.group(0)
            if name in self.keys:
                table = merged(found.group(0).splitlines()[1:-1], table.splitlines(), self.keys[name])
            return found.group(1) + table + found.group(3)

        return TABLE_MARKS.sub(replacement, text)

    @guarded
    def main(self):
        """The command: writes the page anew from a folder of results."""
        parser = argparse.ArgumentParser(description=f"Tables of {self.path.relative_to(ROOT)} from results' files.")
        parser.add_argument("results", type=pathlib.Path, help="folder with `benchmarks` and `cases`")
        parser.add_argument("--page", default=self.path, type=pathlib.Path)
        options = parser.parse_args()
        options.page.write_text(self.filled(options.page.read_text(), options.results))
