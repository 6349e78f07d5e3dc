"""The options that a scenario was built with, kept in it, so that a change of one needs no others to be typed again."""

import inspect
import os
from collections.abc import Mapping
from pathlib import Path
from typing import Annotated, Any, get_args, get_origin

from pydantic import TypeAdapter, ValidationError

from skyverse.errors import InputError

FILES = ("terrain", "buildings", "zones", "voxels", "soft_zones")
"""Options whose words are files; what stands behind an = is not of the file's name."""

Words = tuple[tuple[str, ...], ...]


def kept_words(given: Mapping[str, Any], folder: Path) -> Words:
    """Return options as words, with the files' paths as seen from a folder."""
    words = []
    for name, value in given.items():
        told = [str(one) for one in (value if isinstance(value, list | tuple) else [value])]
        words.append((name, *(_moved(one, Path(), folder) if name in FILES else one for one in told)))
    return tuple(words)


def given_again(source: str, words: Words, options: Mapping[str, inspect.Parameter]) -> dict[str, Any]:
    """Return the options that a scenario's file keeps, as the command line gives them."""
    given: dict[str, Any] = {}
    for name, *told in words:
        if name not in options or not told:
            raise InputError(f"{source}: built_with: expected options of scenario build, found {name!r:.60}")
        if name in FILES:
            told = [_moved(word, Path(source).parent, Path()) for word in told]
        kind = options[name].annotation
        kind = get_args(kind)[0] if get_origin(kind) is Annotated else kind
        several = any(get_origin(one) is list for one in (kind, *get_args(kind)))
        try:
            given[name] = TypeAdapter(kind).validate_python(told if several else told[0])
        except ValidationError:
            raise InputError(f"{source}: built_with: {name}: found {told!r:.100}, which it does not take") from None
    return given


def _moved(word: str, begin: Path, end: Path) -> str:
    """Return a file, and what follows it behind an =, as it is seen from one folder instead of another."""
    file, equals, rest = word.partition("=") if not (begin / word).exists() else (word, "", "")
    try:
        return Path(os.path.relpath(begin / file, end)).as_posix() + equals + rest
    except ValueError:  # on another drive of Windows
        return (begin / file).resolve().as_posix() + equals + rest
