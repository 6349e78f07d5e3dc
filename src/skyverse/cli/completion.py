"""What the shell completes when a user presses TAB: scenarios by name, and files."""

from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from cyclopts.completion import CompletionContext


def scenarios_and_files(context: "CompletionContext") -> Iterator[str]:
    """Yield the names of the built-in scenarios, and the files that begin with what is typed."""
    from skyverse.files import BUILTIN_NAMES

    yield from BUILTIN_NAMES
    yield from files(context)


def files(context: "CompletionContext") -> Iterator[str]:
    """Yield the files and folders that begin with what is typed; of a single folder also what is in it.

    The shell would end the word after a folder that is the only answer.
    """
    typed = context.incomplete
    found = list(_beginning_with(typed))
    yield from found
    if len(found) == 1 and found[0].endswith("/"):
        yield from _beginning_with(found[0])


def _beginning_with(typed: str) -> Iterator[str]:
    """Yield the paths that begin with what is typed, folders with a slash; hidden ones only where a dot is typed."""
    folder, slash, start = typed.rpartition("/")
    try:
        entries = sorted(Path(folder + slash or ".").iterdir())
    except OSError:
        return
    for entry in entries:
        if entry.name.startswith(start) and (start or not entry.name.startswith(".")):
            yield f"{folder}{slash}{entry.name}{'/' if entry.is_dir() else ''}"
