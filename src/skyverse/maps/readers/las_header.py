"""Whether the counts in the header of a LAS or LAZ file fit its size.

Libraries believe these counts, and loop or allocate for as many records as the header claims.

Source: ASPRS LAS 1.4 R15, the public header block; laszip.org for the LASzip record 22204.
"""

import struct
from pathlib import Path
from typing import BinaryIO

from skyverse.errors import InputError

_LASZIP_RECORD = 22204
_MAX_POINTS = 2**31
_MAX_RECORD_BYTES = 2**26
_MAX_POINTS_PER_BYTE = 1000
"""Points that a compressed file may claim for each byte: many times what compression achieves."""
_MAX_CHUNK_POINTS = 10_000_000


def require_sound_header(path: Path) -> None:
    """Raise `InputError` for a file whose counts do not fit its size."""
    try:
        with path.open("rb") as file:
            problem = _first_problem(file, path.stat().st_size)
    except OSError as error:
        raise InputError(f"{path}: cannot be read: {error.strerror or error}") from None
    if problem is not None:
        raise InputError(f"{path}: cannot be read as LAS, it is cut off or damaged: {problem}")


def _first_problem(file: BinaryIO, size: int) -> str | None:
    """Return what is wrong with the counts, if anything."""
    head = file.read(375)
    problem = _header_problem(head, size)
    if problem is not None:
        return problem
    offset, _, compressed, width = _points(head)
    begins, count = struct.unpack_from("<H", head, 94)[0], struct.unpack_from("<I", head, 100)[0]
    file.seek(begins)
    records = file.read(min(offset - begins, _MAX_RECORD_BYTES))
    problem = _record_problem(records, count)
    if problem is not None or not compressed:
        return problem
    if size < offset + 8:
        return "its points are missing"
    file.seek(offset)
    table = struct.unpack("<q", file.read(8))[0]
    if table == -1:  # the table's place stands at the end of the file
        file.seek(size - 8)
        table = struct.unpack("<q", file.read(8))[0]
    if not offset <= table <= size - 8:
        return "its table of chunks is missing"
    file.seek(table)
    chunks = struct.unpack("<II", file.read(8))[1]
    return f"it claims {chunks} chunks" if chunks > size else _compression_problem(records, count, width)


def _points(head: bytes) -> tuple[int, int, bool, int]:
    """Return where points begin, how many, whether compressed, and the bytes of one."""
    offset, _, form, width, count = struct.unpack_from("<IIBHI", head, 96)
    if head[25] >= 4 and len(head) >= 255:
        count = max(count, struct.unpack_from("<Q", head, 247)[0])
    return offset, count, form & 0x80 != 0, width


def _header_problem(head: bytes, size: int) -> str | None:
    """Return what is wrong with the header of a file of that many bytes."""
    if len(head) < 227 or head[:4] != b"LASF":
        return "expected a header that begins with 'LASF'"
    offset, count, compressed, width = _points(head)
    begins, records = struct.unpack_from("<H", head, 94)[0], struct.unpack_from("<I", head, 100)[0]
    if not begins <= offset <= size:
        return f"its points begin at byte {offset} of {size}"
    if 54 * records > offset - begins:
        return f"it claims {records} records before its points"
    if head[25] >= 4 and len(head) >= 255:
        start, more = struct.unpack_from("<QI", head, 235)
        if more and not (offset <= start <= size and 60 * more <= size - start):
            return f"it claims {more} records after its points"
    if not width:
        return "its points have no bytes"
    if count > min(_MAX_POINTS, (size - offset) * _MAX_POINTS_PER_BYTE if compressed else (size - offset) // width):
        return f"it claims {count} points in {size - offset} bytes"
    return None


def _record_problem(records: bytes, count: int) -> str | None:
    """Return what is wrong with the variable length records."""
    at = 0
    for number in range(count):
        if at + 54 > len(records):
            return f"its record {number + 1} is cut off"
        at += 54 + struct.unpack_from("<H", records, at + 20)[0]
    return None if at <= len(records) else f"its record {count} is cut off"


def _compression_problem(records: bytes, count: int, width: int) -> str | None:
    """Return what is wrong with the record that says how points of `width` bytes are compressed."""
    at = 0
    for _ in range(count):
        number, length = struct.unpack_from("<HH", records, at + 18)
        if number == _LASZIP_RECORD and length >= 34:
            chunk, items = struct.unpack_from("<I", records, at + 66)[0], struct.unpack_from("<H", records, at + 86)[0]
            if chunk != 0xFFFFFFFF and not 0 < chunk <= _MAX_CHUNK_POINTS:
                return f"it claims {chunk} points a chunk"
            if length < 34 + 6 * items:
                return f"it claims {items} parts of a point"
            parts = sum(struct.unpack_from("<H", records, at + 90 + 6 * k)[0] for k in range(items))
            return None if parts == width else f"its points have {width} bytes, their parts {parts}"
        at += 54 + length
    return "it does not say how it is compressed"
