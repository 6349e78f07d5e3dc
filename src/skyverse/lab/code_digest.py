"""What makes a run: a digest of its code, so that what has been edited is never taken for done, and all versions."""

import dataclasses
import hashlib
import os
import sys
from collections.abc import Iterator
from datetime import UTC, datetime
from functools import cache
from importlib.metadata import PackageNotFoundError, version
from importlib.util import find_spec
from pathlib import Path

from skyverse._version import __version__
from skyverse.errors import InputError
from skyverse.planners.base import provenance


def code_digest(*made_by: object) -> str:
    """Return a digest of skyverse's source and of the modules from which own planners, objectives or policies come.

    Of a module in a package, the whole package counts.

    Raises
    ------
    InputError
        If there is a module without a file.
    """
    return digest(_of_skyverse(), *(_of_module(module) for module in sorted(_own_modules(made_by))))


def versions(*made_by: object) -> str:
    """Return in words the versions of all that takes part in a run, the processor, and the day."""
    from llvmlite.binding import get_host_cpu_name

    told = [f"skyverse {__version__} ({_of_skyverse()[:12]})", provenance("", None, None).platform]
    libraries = dict.fromkeys(filter(None, (getattr(part, "library", "") for part in _parts(made_by))))
    told += [f"{package} {version(package)}" for package in ("numba", "scipy", *libraries)]
    for module in sorted(_own_modules(made_by)):
        try:
            told.append(f"{module} {version(module)} ({_of_module(module)[:12]})")
        except PackageNotFoundError:
            told.append(f"{module} ({_of_module(module)[:12]})")
    return ", ".join([*told, f"{os.cpu_count()} cores ({get_host_cpu_name()})", f"{datetime.now(UTC):%Y-%m-%d}"])


def _parts(thing: object) -> Iterator[object]:
    """Yield a thing, its settings, what is in tuples of these, and so on."""
    yield thing
    for part in vars(thing).values() if dataclasses.is_dataclass(thing) else thing if isinstance(thing, tuple) else ():
        yield from _parts(part)


def _own_modules(thing: object) -> set[str]:
    """Return the top-level modules that are not Python's, numpy's or skyverse's of all parts of a thing."""
    tops = {
        module.partition(".")[0].replace("__mp_main__", "__main__")  # as spawned processes say
        for part in _parts(thing)
        for module in (getattr(part, "__module__", None) or "", *(kind.__module__ for kind in type(part).__mro__))
    }
    return tops - sys.stdlib_module_names - {"skyverse", "numpy", ""}


@cache
def _of_skyverse() -> str:
    return _of_module("skyverse")


def _of_module(name: str) -> str:
    spec = None if name == "__main__" else find_spec(name)
    file = getattr(sys.modules["__main__"], "__file__", None) if spec is None else spec.origin
    folders = [] if spec is None else spec.submodule_search_locations or []
    if file is None and not folders:
        raise InputError(
            "expected a planner or an objective whose source is in a file, since edited code must not be taken for "
            f"done; {name} has none",
            field="planner",
        )
    files = sorted(each for folder in folders for each in Path(folder).rglob("*.py")) or [Path(str(file))]
    return digest(*(each.read_bytes() for each in files))


def digest(*parts: object) -> str:
    """Return a digest of what things say of themselves."""
    return hashlib.sha256(repr(parts).encode()).hexdigest()
