"""LAS and LAZ files opened by laspy; whatever a damaged file makes laspy raise becomes one sentence."""

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from skyverse.errors import InputError, first_line
from skyverse.maps.readers.las_header import require_sound_header


@contextmanager
def open_las(path: Path) -> Iterator[Any]:
    """Open a point cloud; a damaged file raises `InputError`, here or while it is read."""
    import laspy  # type: ignore[import-untyped, unused-ignore]

    require_sound_header(path)
    try:
        with laspy.open(path) as file:
            yield file
    except (InputError, GeneratorExit, KeyboardInterrupt, SystemExit):
        raise
    except OSError as error:
        raise InputError(f"{path}: cannot be read: {error.strerror or error}") from None
    except BaseException as error:  # a panic of the unpacker, which is written in Rust, is no `Exception`
        raise InputError(f"{path}: cannot be read as LAS: {first_line(error)[:200]}") from None
