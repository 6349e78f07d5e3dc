"""What makes a run: its settings in words, a digest of its code, and all versions."""

import ast
import dataclasses
import hashlib
import os
import sys
from collections.abc import Iterator
from contextlib import suppress
from datetime import UTC, datetime
from enum import Enum
from importlib import import_module
from importlib.util import find_spec
from pathlib import Path, PurePath
from types import FunctionType

import numpy as np

from skyverse._version import __version__
from skyverse.errors import InputError, shown
from skyverse.planners.base import provenance


def settings_of(thing: object) -> str:
    """Return a planner, an objective or a policy in words: its class and all its settings, also those its repr omits.

    Raises
    ------
    InputError
        If a setting has no words that are the same in each process, such as a lambda.
    """
    if thing is None or isinstance(thing, int | float | str | PurePath | Enum | np.generic):
        return repr(thing)
    if isinstance(thing, type | FunctionType) and "<" not in thing.__qualname__:
        return f"{thing.__module__}:{thing.__qualname__}"
    if isinstance(thing, tuple | list):
        inner = ", ".join(map(settings_of, thing))
        return f"[{inner}]" if isinstance(thing, list) else f"({inner})"
    if isinstance(thing, dict):
        return f"{{{', '.join(f'{settings_of(key)}: {settings_of(value)}' for key, value in thing.items())}}}"
    if dataclasses.is_dataclass(thing):
        said = (f"{f.name}={settings_of(getattr(thing, f.name))}" for f in dataclasses.fields(thing))
        return f"{type(thing).__qualname__}({', '.join(said)})"
    raise InputError(
        "expected settings that are numbers, texts, functions at the top of a module, or tuples, lists, mappings and "
        f"dataclasses of these, by which a run is found again, found {shown(thing)}",
        field="planner",
    )


def code_digest(*made_by: object) -> str:
    """Return a digest of the code that makes a run, as this process has imported it.

    That is skyverse's source, the versions of packages, and the source of own planners, objectives or policies: their
    modules, or the whole packages that hold them, and all that these import and that is not installed.

    Raises
    ------
    InputError
        If there is a module without a file.
    """
    own = [(name, _imported(name)[1]) for name in _own_modules(made_by)]
    return digest(_imported("skyverse")[1], np.__version__, _packages(made_by), own)


def refuse_edited(*made_by: object) -> None:
    """Raise `InputError` where the source of own planners, objectives or policies was edited after it was imported."""
    for files, imported in map(_imported, _own_modules(made_by)):
        if _of_files(files) != imported:
            text = f"expected {files[0]} and what it imports as they were imported, found one edited; start Python anew"
            raise InputError(text, field="planner")


def versions(*made_by: object) -> str:
    """Return in words the versions of all that takes part in a run, the processor, and the day."""
    from llvmlite.binding import get_host_cpu_name

    told = [f"skyverse {__version__} ({_imported('skyverse')[1][:12]})", provenance("", None, None).platform]
    told += [*_packages(made_by), *(f"{name} ({_imported(name)[1][:12]})" for name in _own_modules(made_by))]
    return ", ".join([*told, f"{os.cpu_count()} cores ({get_host_cpu_name()})", f"{datetime.now(UTC):%Y-%m-%d}"])


def _packages(made_by: object) -> list[str]:
    """Return the names and versions of the packages that take part in a run, but for numpy."""
    libraries = filter(None, (getattr(part, "library", "") for part in _parts(made_by)))
    names = dict.fromkeys(("numba", "scipy", *libraries))
    return [f"{name} {import_module(name).__version__}" for name in names]


def _parts(thing: object) -> Iterator[object]:
    """Yield a thing, its settings, what is in tuples, lists and mappings of these, and so on."""
    yield thing
    if isinstance(thing, dict):
        thing = (*thing, *thing.values())
    elif dataclasses.is_dataclass(thing) and not isinstance(thing, type):
        thing = tuple(vars(thing).values())
    for part in thing if isinstance(thing, tuple | list) else ():
        yield from _parts(part)


def _own_modules(thing: object) -> list[str]:
    """Return the modules that are not Python's, numpy's or skyverse's of all parts of a thing."""
    modules = {
        (getattr(each, "__module__", None) or "skyverse").replace("__mp_main__", "__main__")  # as spawned processes say
        for part in _parts(thing)
        for each in (part, *type(part).__mro__)
    }
    return sorted(module for module in modules if module.partition(".")[0] not in _NOT_OWN)


_NOT_OWN = sys.stdlib_module_names | {"skyverse", "numpy"}


_KEPT = "__source_when_first_seen__"
"""The name under which a module keeps its source files and their digest, so that one imported anew is seen anew."""


def _imported(name: str) -> tuple[list[Path], str]:
    """Return the source files of a module, its package and what they import, and their digest when first seen."""
    module = vars(sys.modules[name]) if name in sys.modules else {}
    if _KEPT not in module:
        files = _files(name) if name == "skyverse" else _sources(name.partition(".")[0])
        module[_KEPT] = files, _of_files(files)
    return module[_KEPT]


def _sources(name: str) -> list[Path]:
    """Return the source files of a top-level module, and of all that it imports and that is not installed."""
    sources: dict[str, list[Path]] = {}
    waiting = [name]
    while waiting:
        module = waiting.pop()
        sources[module] = _files(module)
        waiting += sorted(filter(_is_own, _imports(sources[module]) - sources.keys()))
    return list(dict.fromkeys(file for files in sources.values() for file in files))


def _is_own(module: str) -> bool:
    """Tell whether a module that is imported is neither Python's nor skyverse's nor installed."""
    spec = None if module in _NOT_OWN else find_spec(module)
    return spec is not None and not {"site-packages", "dist-packages"} & {*Path(spec.origin or "").parts}


def _imports(files: list[Path]) -> set[str]:
    """Return the top-level modules that source files import by name."""
    found = set()
    for file in files:
        with suppress(SyntaxError, ValueError):  # it is no Python
            for node in ast.walk(ast.parse(file.read_bytes())):
                if isinstance(node, ast.Import):
                    found |= {alias.name.partition(".")[0] for alias in node.names}
                elif isinstance(node, ast.ImportFrom) and not node.level:
                    found.add(str(node.module).partition(".")[0])
    return found - {"__main__"}


def _files(name: str) -> list[Path]:
    """Return the source files of a top-level module or package."""
    spec = None if name == "__main__" else find_spec(name)
    file = getattr(sys.modules["__main__"], "__file__", None) if spec is None else spec.origin
    folders = [] if spec is None else spec.submodule_search_locations or []
    if file is None and not folders:
        raise InputError(
            "expected a planner or an objective whose source is in a file, since edited code must not be taken for "
            f"done; {name} has none",
            field="planner",
        )
    return sorted(each for folder in folders for each in Path(folder).rglob("*.py")) or [Path(str(file))]


def _of_files(files: list[Path]) -> str:
    return digest(*(file.read_bytes() if file.exists() else None for file in files))


def digest(*parts: object) -> str:
    """Return a digest of what things say of themselves."""
    return hashlib.sha256(repr(parts).encode()).hexdigest()
