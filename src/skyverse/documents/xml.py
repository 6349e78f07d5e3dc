"""XML without a document type, so that it can neither expand its entities nor fetch other files."""

from pathlib import Path
from typing import IO, Protocol
from xml.etree.ElementTree import Element, TreeBuilder
from xml.parsers import expat

from skyverse.documents.limits import LimitError, require_depth, require_values
from skyverse.errors import InputError

_CUT_OFF_CODES = [expat.errors.codes[said] for said in (
    expat.errors.XML_ERROR_NO_ELEMENTS, expat.errors.XML_ERROR_UNCLOSED_TOKEN, expat.errors.XML_ERROR_PARTIAL_CHAR,
    expat.errors.XML_ERROR_UNCLOSED_CDATA_SECTION,
)]  # fmt: skip


class XmlTarget(Protocol):
    """What is told where each element of a file begins and ends.

    Its methods ``data`` and ``comment`` take the texts and comments, if it has them.
    """

    def start(self, tag: str, attrs: dict[str, str], /) -> object:
        """Begin an element."""

    def end(self, tag: str, /) -> object:
        """End the element that began last."""


def parse(stream: IO[bytes], path: Path | str, target: XmlTarget, *, prefixes: bool = False) -> None:
    """Tell a target of each element of a file; names are without their namespace's prefix, unless they are asked for.

    Raises
    ------
    InputError
        If it is not XML, ends too early, declares a document type, or holds too many elements or too deep ones.
    """
    depth = elements = 0

    def start(name: str, attributes: dict[str, str]) -> None:
        nonlocal depth, elements
        depth += 1
        elements += 1
        require_depth(depth)
        require_values(elements)
        target.start(name if prefixes else name.rpartition(":")[2], attributes)

    def end(name: str) -> None:
        nonlocal depth
        depth -= 1
        target.end(name if prefixes else name.rpartition(":")[2])

    def refuse(*_: object) -> None:
        raise InputError(f"{path}: expected plain XML, found a document type declaration")

    parser = expat.ParserCreate()
    parser.buffer_text = True
    parser.StartDoctypeDeclHandler = refuse
    parser.StartElementHandler = start
    parser.EndElementHandler = end
    parser.CharacterDataHandler = getattr(target, "data", None)
    parser.CommentHandler = getattr(target, "comment", None)
    try:
        parser.ParseFile(stream)
    except LimitError as error:
        raise InputError(f"{path}: {error}") from None
    except (expat.ExpatError, UnicodeError, LookupError, ValueError) as error:
        if isinstance(error, InputError):
            raise
        cut = isinstance(error, expat.ExpatError) and error.code in _CUT_OFF_CODES
        found = "it cut off" if cut else "something else"
        raise InputError(f"{path}: expected XML, found {found}: {error}") from None


def read_tree(stream: IO[bytes], path: Path | str, *, whole: bool = False) -> Element:
    """Return the root of a file's elements, whole with prefixes and comments, as for writing it; see `parse`."""
    builder = TreeBuilder(insert_comments=whole)
    parse(stream, path, builder, prefixes=whole)
    return builder.close()
