"""Files that appear whole or not at all: they are written under another name, then renamed."""

import os
import secrets
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

from skyverse.errors import InputError


def require_file_or_nothing(path: Path) -> None:
    """Raise `InputError` for a folder, a device or a pipe, which a file that took its name would replace."""
    if path.exists() and not path.is_file():
        found = "a folder" if path.is_dir() else "a device or a pipe"
        raise InputError(f"{path}: expected a file, found {found}")


@contextmanager
def whole_file(path: Path) -> Iterator[Path]:
    """Yield a path in a file's folder, with its suffix, to write to; what is written there becomes the file at the end.

    Raises
    ------
    InputError
        If the file cannot be written. Then nothing is left behind, and an older file stays as it was.
    """
    require_file_or_nothing(path)
    beside = path.with_name(f".{path.stem}-{secrets.token_hex(4)}{path.suffix}")
    try:
        try:
            yield beside
            os.replace(beside, path)  # noqa: PTH105 (replaces on Windows too)
        except BaseException:
            with suppress(OSError, ValueError):
                beside.unlink(missing_ok=True)
            raise
    except InputError:  # of another file, which is written beside this one
        raise
    except OSError as error:
        raise InputError(f"{path}: cannot be written: {error.strerror or error}") from None
    except ValueError as error:  # no file can have that name
        raise InputError(f"{str(path)!r}: cannot be written: {error}") from None


def write_text(path: Path, text: str) -> None:
    """Write a text file in UTF-8; see `whole_file`."""
    with whole_file(path) as beside:
        beside.write_text(text, encoding="utf-8", newline="\n")
