"""XML without a document type, so that it can neither expand its entities nor fetch other files."""

from collections.abc import Callable, Mapping
from pathlib import Path
from typing import IO
from xml.parsers import expat

from skyverse.errors import InputError

_CUT_OFF_CODES = [expat.errors.codes[said] for said in (
    expat.errors.XML_ERROR_NO_ELEMENTS, expat.errors.XML_ERROR_UNCLOSED_TOKEN, expat.errors.XML_ERROR_PARTIAL_CHAR,
    expat.errors.XML_ERROR_UNCLOSED_CDATA_SECTION,
)]  # fmt: skip


def parse(
    stream: IO[bytes],
    path: Path,
    start: Callable[[str, Mapping[str, str]], None],
    end: Callable[[str], None],
    text: Callable[[str], None] | None = None,
) -> None:
    """Call `start`, `end` and `text` for each element and text of a file; names are without their namespace's prefix.

    Raises
    ------
    InputError
        If it is not XML, ends too early, or declares a document type.
    """

    def refuse(*_: object) -> None:
        raise InputError(f"{path}: expected plain XML, found a document type declaration")

    parser = expat.ParserCreate()
    parser.buffer_text = True
    parser.StartDoctypeDeclHandler = refuse
    parser.StartElementHandler = lambda name, attributes: start(name.rpartition(":")[2], attributes)
    parser.EndElementHandler = lambda name: end(name.rpartition(":")[2])
    if text is not None:
        parser.CharacterDataHandler = text
    try:
        parser.ParseFile(stream)
    except (expat.ExpatError, UnicodeError, LookupError, ValueError) as error:
        if isinstance(error, InputError):
            raise
        cut = isinstance(error, expat.ExpatError) and error.code in _CUT_OFF_CODES
        found = "it cut off" if cut else "something else"
        raise InputError(f"{path}: expected XML, found {found}: {error}") from None
