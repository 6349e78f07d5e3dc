"""The libraries that reading maps needs, and what to say where they are absent."""

from importlib.util import find_spec

from skyverse.errors import InputError


def needs(what: str, *modules: str) -> None:
    """Refuse, with the line that installs them, unless all modules are there.

    Parameters
    ----------
    what
        What needs them, such as a file's name.
    """
    missing = [name for name in modules if find_spec(name) is None]
    if missing:
        raise InputError(f'{what}: reading this needs {" and ".join(missing)}: pip install "skyverse[maps]"')
