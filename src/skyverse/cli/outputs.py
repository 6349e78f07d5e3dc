"""Files and folders that a verb writes: their names, and whether they can be written at all."""

import os
import re
import sys
from contextlib import suppress
from itertools import chain, count
from pathlib import Path
from typing import TYPE_CHECKING

from skyverse.atomic import require_file_or_nothing
from skyverse.errors import InputError

if TYPE_CHECKING:
    from skyverse.model.scenario import Scenario

DEFAULT_FOLDER = Path("out")
"""Where files go whose place the user has not named, and which is made without a word."""
_MADE: list[Path] = []
"""The folders that were made, those above first."""


def file_name(name: str) -> str:
    """Return a sound file name for a scenario or study, whatever its own name holds."""
    return re.sub(r"[^\w.-]+", "_", name).strip("._")[:100] or "mission"


def mission_file(source: str, scenario: "Scenario") -> Path:
    """Return the file, named after the source of a scenario, that replaces no mission of another scenario.

    Where the first name holds another scenario, or no mission at all, it is ``NAME-2.json``, ``NAME-3.json`` and so on.
    """
    from skyverse.files import BUILTIN_NAMES

    name = file_name(source if source in BUILTIN_NAMES else Path(source).stem)
    names = (DEFAULT_FOLDER / f"{name}{number}.json" for number in chain([""], map("-{}".format, count(2))))
    taken = []
    for path in names:
        if not path.exists() or _may_replace(path, source, scenario):
            break
        taken.append(path)
    if taken:
        why = "is what is read" if _is_read(taken[0], source) else "is of another scenario"
        print(f"{taken[0]} {why} and stays as it is; this mission is {path}.", file=sys.stderr)
    return path


def source_from(path: Path, source: str) -> str:
    """Return what a scenario was read from, as a mission that is written to `path` names it; see `Mission.source`."""
    from skyverse.files import BUILTIN_NAMES

    if source in BUILTIN_NAMES:
        return source
    try:
        return Path(os.path.relpath(Path(source).resolve(), path.parent.resolve())).as_posix()
    except ValueError:  # on another drive of Windows
        return Path(source).resolve().as_posix()


def _may_replace(path: Path, source: str, scenario: "Scenario") -> bool:
    """Tell whether a file is a mission of the same source, which may have been changed since, or of the same scenario.

    The file that is read is never replaced.
    """
    from skyverse.files import read_mission

    if _is_read(path, source):
        return False
    try:
        found = read_mission(path)
    except InputError:
        return False
    return found.source == source_from(path, source) or found.scenario.digest == scenario.digest


def _is_read(path: Path, source: str) -> bool:
    """Tell whether a file is the source of a scenario."""
    return Path(source).exists() and path.samefile(source)


def make_folder(folder: Path) -> None:
    """Make a folder and those above it, unless they exist; `settle_folders` tells of them."""
    missing = [one for one in (*reversed(folder.parents), folder) if not one.exists()]
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except FileExistsError:
        raise InputError(f"{folder}: expected a folder, found a file") from None
    except OSError as error:
        raise InputError(f"{folder}: cannot be made: {error.strerror}") from None
    _MADE.extend(missing)


def settle_folders() -> None:
    """Remove the folders that were made and hold nothing; tell of the others, as each may be a misspelt one."""
    for folder in reversed(_MADE):
        with suppress(OSError):
            folder.rmdir()  # only where it is empty
    left = [folder for folder in _MADE if folder.exists() and not any(folder in one.parents for one in _MADE)]
    for folder in left:
        if DEFAULT_FOLDER not in (folder, *folder.parents):
            print(f"Made the folder {folder}, which did not exist.", file=sys.stderr)
    _MADE.clear()


def refuse_output(path: Path, *read: str | Path) -> None:
    """Refuse, before a long run, a file that cannot be written, or that would replace one of those that are read."""
    make_folder(path.parent)
    if path.exists() and any(Path(one).exists() and path.samefile(one) for one in read):
        raise InputError(f"{path}: expected another file than what is read, which would be replaced")
    require_file_or_nothing(path)
    if not os.access(path.parent, os.W_OK):
        raise InputError(f"{path}: cannot be written: the folder is read-only")
