"""The libraries that come with extras of the package, and the one line that installs those that are missing."""

import os
import sys
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from contextvars import ContextVar
from importlib.util import find_spec
from pathlib import Path

from skyverse.errors import InputError

EXTRAS = {
    "maps": ("laspy", "lazrs", "pyogrio", "pyproj", "rasterio", "trimesh"),
    "tours": ("pyvrp",),
    "flight": ("imageio_ffmpeg", "rotorpy"),
    "optimisers": ("cma", "niapy", "pymoo"),
    "parquet": ("pyarrow",),
    "dask": ("distributed",),
}
"""The modules that skyverse imports from each extra."""

_HERE = Path(__file__)
_found: ContextVar[list[tuple[str, str]] | None] = ContextVar("found", default=None)


def require_libraries(what: str, *modules: str, field: str | None = None) -> None:
    """Raise `InputError`, with the line that installs them, unless all modules are installed.

    Parameters
    ----------
    what
        What needs the modules, such as a file's name.
    modules
        The modules' names.
    field
        The parameter that asks for it.
    """
    missing = [(what, name) for name in modules if find_spec(name) is None]
    found = _found.get()
    if found is not None:
        found += missing
    elif missing:
        raise _lack(missing, field)


@contextmanager
def missing_at_once() -> Iterator[None]:
    """Let one `InputError` at the end name all that `require_libraries` finds missing within."""
    found: list[tuple[str, str]] = []
    before = _found.set(found)
    try:
        with told_imports():
            yield
    except InputError:
        if not found:
            raise
    finally:
        _found.reset(before)
    if found:
        raise _lack(found)


@contextmanager
def told_imports() -> Iterator[None]:
    """Turn an import that fails for want of an extra into `InputError`, with the line that installs it."""
    try:
        yield
    except ModuleNotFoundError as error:
        module = str(error.name).partition(".")[0]
        if not _extras_of([module]):
            raise
        raise _lack([("this", module)]) from None


def _lack(missing: Sequence[tuple[str, str]], field: str | None = None) -> InputError:
    whats, modules = (list(dict.fromkeys(names)) for names in zip(*missing, strict=True))
    verb = "needs" if len(whats) == 1 else "need"
    said = f"{' and '.join(whats)} {verb} {' and '.join(modules)}, not installed here"
    return InputError(f"{said}: {install_line(_extras_of(modules))}", field=field)


def _extras_of(modules: Sequence[str]) -> list[str]:
    return [extra for extra, those in EXTRAS.items() if {*those} & {*modules}]


def install_line(extras: Sequence[str]) -> str:
    """Return the line that installs extras: into a clone of the source an editable one, from its folder or another."""
    names = ",".join(extras)
    clone = next((one for one in (_HERE.parents[2], Path(sys.prefix).parent) if (one / "run.py").is_file()), None)
    if clone is None:
        return f'pip install "skyverse[{names}]"'
    pip = Path(sys.prefix) / ("Scripts" if os.name == "nt" else "bin") / "pip"
    if Path.cwd() != clone:
        return f'{pip} install -e "{clone}[{names}]"'
    return f'{pip.relative_to(clone) if pip.is_relative_to(clone) else pip} install -e ".[{names}]"'
