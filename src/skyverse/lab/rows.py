"""The rows of a study of planners in one SQLite file."""

from collections.abc import Iterator
from contextlib import closing
from pathlib import Path

from skyverse.lab.columns import unpacked
from skyverse.lab.row import RUN_COLUMNS, Row
from skyverse.lab.row_export import export_rows
from skyverse.lab.row_file import RowFile
from skyverse.model.result import History


class Rows(RowFile[Row]):
    """The rows of a study, kept in a file; a context manager that closes the file.

    Rows are returned in the study's order of scenarios, planners and budgets, and then by seed. Other processes may
    read the file while a study writes it.

    Parameters
    ----------
    path
        A SQLite file, which is created if it does not exist.

    Raises
    ------
    InputError
        If the file cannot be opened, or is not a database of rows.
    """

    kind = Row
    label_kinds = RUN_COLUMNS[:-1]

    def histories(self, **where: object) -> Iterator[History]:
        """Yield the histories of the rows that `select` returns, in the same order, reading one at a time."""
        with closing(self._find(("history",), where)) as found:
            for (history,) in found:
                yield unpacked(history)

    def export(self, path: str | Path) -> list[Path]:
        """Write the rows as ``.csv`` or ``.parquet``, and their histories to a second file; return both paths."""
        return export_rows(self, path)
