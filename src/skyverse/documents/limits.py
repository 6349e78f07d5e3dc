"""How much a nested document may hold; a reader counts it before it builds anything of that size.

The limits are far above what maps and missions need, and low enough that a document at its limits fits into memory.
"""

from pathlib import Path

from skyverse.errors import InputError, unreadable

MAX_DIGITS = 250
"""Digits of a whole number at most: so each can become a float, hexadecimal ones, too."""
MAX_DEPTH = 100
"""Lists, objects or elements within one another at most; the deepest format that is read, CityJSON, needs about 12."""
MAX_REPEATED = 100_000
"""Values that the aliases of a YAML document may repeat in all; a few lines of aliases could repeat billions."""
MAX_VALUES = 2**25
"""Values in a document at most, 33 million: as Python objects they take about 2 GB."""
MAX_BYTES = 2**29
"""Bytes of a document's file at most, half a gigabyte."""


class LimitError(ValueError):
    """A document holds more than is read; the message says what was expected and found."""


def read_bytes(path: Path) -> bytes:
    """Return what a file holds, or raise `InputError` where it cannot be read, or is too long for a document."""
    with unreadable(path):
        size = path.stat().st_size
        if size > MAX_BYTES:
            raise InputError(f"{path}: expected at most {MAX_BYTES:,} bytes, found {size:,}")
        return path.read_bytes()


def text_of(content: bytes, where: object) -> str:
    """Return the text that bytes of UTF-8 hold, or raise `InputError`; `where` names them."""
    try:
        return content.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        raise InputError(f"{where}: expected a text in UTF-8, found something else at byte {error.start}") from None


def require_values(values: int) -> None:
    """Raise `LimitError` for a document that holds too many values."""
    if values > MAX_VALUES:
        raise LimitError(f"expected at most {MAX_VALUES:,} values, found {values:,} or more")


def require_depth(depth: int) -> None:
    """Raise `LimitError` for a document whose parts stand too deeply within one another."""
    if depth > MAX_DEPTH:
        raise LimitError(f"expected its parts nested at most {MAX_DEPTH} deep, found them {depth:,} deep or more")


def require_digits(digits: int, where: str = "") -> None:
    """Raise `LimitError` for a number of too many digits; `where` begins the message."""
    if digits > MAX_DIGITS:
        raise LimitError(f"{where}expected numbers of at most {MAX_DIGITS:,} digits, found one of {digits:,}")
