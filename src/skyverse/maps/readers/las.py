"""LAS and LAZ files as laspy opens them; whatever a broken one makes it raise is one sentence."""

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from skyverse.errors import InputError
from skyverse.maps.readers.las_header import require_sound


@contextmanager
def opened(path: Path) -> Iterator[Any]:
    """Open a point cloud, or raise `InputError`; so does reading on, until it is closed."""
    import laspy  # type: ignore[import-untyped, unused-ignore]

    require_sound(path)
    try:
        with laspy.open(path) as file:
            yield file
    except (InputError, GeneratorExit, KeyboardInterrupt, SystemExit):
        raise
    except OSError as error:
        raise InputError(f"{path}: cannot be read: {error.strerror or error}") from None
    except BaseException as error:  # the unpacker, which is written in Rust, gives up with no `Exception`
        said = (str(error).strip().splitlines() or [type(error).__name__])[0]
        raise InputError(f"{path}: cannot be read as LAS: {said[:200]}") from None
