"""KMZ: archives of XML files, unpacked within limits, so that no file can fill the memory, and packed again."""

import io
import zipfile
import zlib
from collections.abc import Callable, Iterable, Mapping
from pathlib import Path
from typing import IO

from skyverse.errors import InputError, printable

MAX_UNPACKED = 200_000_000
"""Bytes that what is read of an archive may unpack to at most."""


def unpacked(stream: IO[bytes], path: Path | str, choose: Callable[[list[str]], Iterable[str]]) -> dict[str, bytes]:
    """Return the files of an archive that are chosen among all names in it, by their names.

    Raises
    ------
    InputError
        If it is no archive, is damaged, or unpacks to too much.
    """
    found: dict[str, bytes] = {}
    try:
        with zipfile.ZipFile(stream) as archive:
            left = MAX_UNPACKED
            for name in choose(archive.namelist()):
                with archive.open(name) as packed:
                    found[name] = packed.read(left + 1)
                left -= len(found[name])
                if left < 0:
                    break
    except InputError:
        raise
    except (zipfile.BadZipFile, zlib.error, EOFError, RuntimeError, NotImplementedError, ValueError) as error:
        stream.seek(0)
        said = "it cut off or damaged" if stream.read(2) == b"PK" else "something else"
        raise InputError(f"{path}: expected a KMZ archive, found {said}: {printable(str(error))}") from None
    if left < 0:
        raise InputError(f"{path}: expected less than {MAX_UNPACKED / 1e6:g} MB when unpacked, found more")
    return found


def repacked(content: bytes, path: Path | str, changed: Mapping[str, bytes]) -> bytes:
    """Return an archive with some of its files changed, and all others as they are."""
    made = io.BytesIO()
    with zipfile.ZipFile(io.BytesIO(content)) as before, zipfile.ZipFile(made, "w") as after:
        if sum(info.file_size for info in before.infolist()) > MAX_UNPACKED:
            raise InputError(f"{path}: expected less than {MAX_UNPACKED / 1e6:g} MB when unpacked, found more")
        after.comment = before.comment
        for info in before.infolist():
            text = changed.get(info.filename)
            after.writestr(info, before.read(info) if text is None else text)
    return made.getvalue()
