"""The options that a scenario was built with: a file holds the paths among them as they are seen from its folder."""

import os
from pathlib import Path
from typing import Annotated

from pydantic import AfterValidator, PlainSerializer, SerializationInfo, ValidationInfo

FILES = {"terrain", "around", "buildings", "zones", "fence", "max_heights", "voxels", "soft_zones"}
"""Options whose words are files; behind the = of a soft zone stands its risk."""

Words = tuple[tuple[str, ...], ...]


def _moved(words: Words, begin: Path, end: Path | None) -> Words:
    """Return options whose files are seen from one folder as they are seen from another one, or else from anywhere."""

    def moved(name: str, word: str) -> str:
        file, equals, risk = word.rpartition("=") if name == "soft_zones" else (word, "", "")
        whole = (begin / file).resolve()
        try:
            seen = whole if end is None else Path(os.path.relpath(whole, end.resolve()))
        except ValueError:  # on another drive of Windows
            seen = whole
        return seen.as_posix() + equals + risk

    return tuple((*row[:1], *(moved(row[0], one) for one in row[1:])) if {*row[:1]} & FILES else row for row in words)


def _read(words: Words, info: ValidationInfo) -> Words:
    folder = (info.context or {}).get("folder")
    return words if folder is None else _moved(words, folder, None)


def _written(words: Words, info: SerializationInfo) -> Words:
    folder = (info.context or {}).get("folder")
    return words if folder is None else _moved(words, Path(), folder)


BuiltWith = Annotated[Words, AfterValidator(_read), PlainSerializer(_written)]
"""Options, each a name and what was written after it; paths are whole, but for files, whose `folder` they start at."""
