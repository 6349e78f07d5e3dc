"""Files that appear whole or not at all: written beside, then renamed."""

import os
import secrets
from pathlib import Path

from skyverse.errors import InputError


def write_bytes(path: Path, content: bytes) -> None:
    """Write a file; on failure nothing is left behind and an older file stays, and `InputError` says why."""
    beside = path.with_name(f".{path.name}.{secrets.token_hex(4)}.tmp")
    try:
        try:
            beside.write_bytes(content)
            os.replace(beside, path)  # noqa: PTH105 (replaces on Windows too)
        except BaseException:
            beside.unlink(missing_ok=True)
            raise
    except OSError as error:
        raise InputError(f"{path}: cannot be written: {error.strerror or error}") from None


def write_text(path: Path, text: str) -> None:
    """Write a text file in UTF-8; see `write_bytes`."""
    write_bytes(path, text.encode("utf-8"))
