"""The libraries that reading maps needs, and what a user is told where they are not installed."""

from importlib.util import find_spec

from skyverse.errors import InputError


def require_libraries(what: str, *modules: str) -> None:
    """Raise `InputError`, with the line that installs them, unless all modules are installed.

    Parameters
    ----------
    what
        What needs the modules, such as a file's name.
    modules
        The modules' names.
    """
    missing = [name for name in modules if find_spec(name) is None]
    if missing:
        raise InputError(f'{what}: reading this needs {" and ".join(missing)}: pip install "skyverse[maps]"')
