"""Large arrays in a compressed archive beside the file that refers to them: ``city.yaml`` and ``city.yaml.grids.npz``.

The archive is NumPy's. Heights are float32 where that loses nothing, and float64 otherwise; booleans are packed, eight
a byte. A reference holds the archive's name, the array's name and shape, and the SHA-256 of the array as it is stored.
"""

import hashlib
import io
import math
import tokenize
import zipfile
import zlib
from pathlib import Path
from typing import IO, Any

import numpy as np
from numpy.typing import NDArray

from skyverse.errors import shown

_HEAD = 10
"""Bytes of an .npy file of version 1.0 before its description, the last two of which say how long that is."""
_PART = 2**20
"""Bytes that are unpacked at a time."""
MAX_ARRAY_NUMBERS = 2**26
"""Numbers at most in an array that is read: half a gigabyte of heights."""


def archive_path(path: Path) -> Path:
    """Return the path of the archive beside a file; different files have different archives."""
    return path.with_name(f"{path.name}.grids.npz")


class GridArchive:
    """The arrays of the archive beside a file; called with an array, it keeps it and returns its reference."""

    def __init__(self, path: Path) -> None:
        self.path = archive_path(path)
        self._entries: dict[str, bytes] = {}

    def __call__(self, array: NDArray[Any]) -> dict[str, object]:
        """Keep an array, unless an equal one is kept already, and return the reference to it."""
        data = _entry(array)
        digest = hashlib.sha256(data).hexdigest()
        name = f"{'occupied' if array.dtype == bool else 'heights'}-{digest[:16]}"
        self._entries[name] = data
        return {"file": self.path.name, "array": name, "shape": list(array.shape), "sha256": digest}

    @property
    def context(self) -> dict[str, Any]:
        """What models are written with."""
        return {"side": self, "folder": self.path.parent}

    def __bool__(self) -> bool:
        return bool(self._entries)

    def write_to(self, file: Path) -> None:
        """Write the archive to a file; the same arrays give the same bytes."""
        with zipfile.ZipFile(file, "w", zipfile.ZIP_DEFLATED) as archive:
            for name, data in sorted(self._entries.items()):
                entry = zipfile.ZipInfo(f"{name}.npy")
                entry.compress_type = zipfile.ZIP_DEFLATED
                archive.writestr(entry, data, compresslevel=6)


def _entry(array: NDArray[Any]) -> bytes:
    """Return an array as the bytes of an .npy file."""
    if array.dtype == bool:
        stored: NDArray[Any] = np.packbits(array)
    else:
        with np.errstate(over="ignore", under="ignore"):
            single = array.astype("<f4")
        stored = single if np.array_equal(single, array) else array.astype("<f8")
    out = io.BytesIO()
    np.lib.format.write_array(out, np.ascontiguousarray(stored), version=(1, 0), allow_pickle=False)
    return out.getvalue()


def beside(path: Path) -> dict[str, Any]:
    """Return what models read the file `path` with: its folder, and what returns the array of a reference in it."""
    return {"grids": lambda reference: _load(path, reference), "folder": path.parent}


def _load(path: Path, reference: dict[str, Any]) -> NDArray[Any]:
    if set(reference) != {"file", "array", "shape", "sha256"}:
        raise ValueError("expected rows of numbers, or 'file', 'array', 'shape' and 'sha256' of an array beside")
    file, name, shape, digest = (reference[key] for key in ("file", "array", "shape", "sha256"))
    if not (isinstance(file, str) and file.endswith(".npz") and not set(file) & set("/\\:\0") and file.isprintable()):
        raise ValueError(f"file: expected the plain name of an .npz file in the same folder, found {shown(file, 60)}")
    if not (
        isinstance(shape, list)
        and 1 <= len(shape) <= 3
        and all(type(n) is int and n > 0 for n in shape)
        and math.prod(shape) <= MAX_ARRAY_NUMBERS
    ):
        raise ValueError(
            f"shape: expected two or three counts, {MAX_ARRAY_NUMBERS:,} numbers at most, found {shown(shape, 60)}"
        )
    beside = path.with_name(file)
    try:
        with zipfile.ZipFile(beside) as archive:
            entry = archive.getinfo(f"{name}.npy")
            if entry.file_size > 8 * math.prod(shape) + 1024:
                raise ValueError(f"{file}: {shown(name, 60)} is larger than its shape {shape} says")
            with archive.open(entry) as stream:
                stored, found = _array(stream, shape)
    except KeyError:
        raise ValueError(f"{file} has no array {shown(name, 60)}") from None
    except FileNotFoundError:
        raise ValueError(f"{file}, the file beside this one with its large arrays, is missing") from None
    except OSError as error:
        raise ValueError(f"{file} cannot be read: {error.strerror or error}") from None
    except (zipfile.BadZipFile, zlib.error, EOFError, NotImplementedError, RuntimeError, tokenize.TokenError) as error:
        raise ValueError(f"{file} is damaged: {error}") from None
    if found != digest:
        raise ValueError(
            f"{file}: {shown(name, 60)} is not the array that this file was written with (its SHA-256 differs)"
        )
    if stored is None:
        raise ValueError(f"{file}: {shown(name, 60)} does not have the shape {shape}")
    if stored.dtype == np.uint8:
        return np.unpackbits(stored, count=math.prod(shape)).view(np.bool_).reshape(shape)
    heights = stored.astype(np.float64, copy=False)
    heights.flags.writeable = False  # so that no model copies it
    return heights


def _array(stream: IO[bytes], shape: list[int]) -> tuple[NDArray[Any] | None, str]:
    """Return the numbers of an .npy file, ``None`` if they are not as many as `shape` says, and the file's SHA-256.

    Nothing in the file is run. Heights have the shape; bits are packed, and flat. They are read to where they stay.
    """
    head = stream.read(_HEAD)
    head += stream.read(int.from_bytes(head[8:], "little"))
    with io.BytesIO(head) as file:
        version = np.lib.format.read_magic(file)
        if version != (1, 0):
            raise ValueError(f"expected an array in version 1.0 of NumPy's format, found {version}")
        _, _, dtype = np.lib.format.read_array_header_1_0(file)
    if dtype.str not in ("<f4", "<f8", "|u1"):
        raise ValueError(f"expected an array of numbers, found one of {dtype.str!r}")
    array = np.empty([-(-math.prod(shape) // 8)] if dtype == np.uint8 else shape, dtype)
    room, filled = array.reshape(-1).view(np.uint8), 0
    while filled < len(room) and (part := stream.read(min(_PART, len(room) - filled))):
        room[filled : filled + len(part)] = np.frombuffer(part, np.uint8)
        filled += len(part)
    digest, rest = hashlib.sha256(head), stream.read()
    digest.update(room[:filled].data)
    digest.update(rest)
    return (array if filled == len(room) and not rest else None), digest.hexdigest()
