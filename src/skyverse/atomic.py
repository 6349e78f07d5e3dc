"""Files that appear whole or not at all: written beside, then renamed."""

import os
import secrets
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

from skyverse.errors import InputError


@contextmanager
def whole_file(path: Path) -> Iterator[Path]:
    """Yield a name beside a file, with its suffix, to be written to; what was written there becomes the file.

    Raises
    ------
    InputError
        If the file cannot be written. Nothing is left behind then, and an older file stays as it was.
    """
    beside = path.with_name(f".{path.stem}-{secrets.token_hex(4)}{path.suffix}")
    try:
        try:
            yield beside
            os.replace(beside, path)  # noqa: PTH105 (replaces on Windows too)
        except BaseException:
            with suppress(OSError, ValueError):
                beside.unlink(missing_ok=True)
            raise
    except OSError as error:
        raise InputError(f"{path}: cannot be written: {error.strerror or error}") from None
    except ValueError as error:  # a name that no file can have
        raise InputError(f"{str(path)!r}: cannot be written: {error}") from None


def write_text(path: Path, text: str) -> None:
    """Write a text file in UTF-8; see `whole_file`."""
    with whole_file(path) as beside:
        beside.write_text(text, encoding="utf-8", newline="\n")
