"""An XML file that is changed where it must be, and keeps all its other bytes."""

import io
import re
from xml.etree.ElementTree import Element

from skyverse.documents.xml import SpanBuilder, parse
from skyverse.errors import InputError

_TAG = re.compile(rb"<([^\s/>]+)([^>]*?)/?>")


class XmlText:
    """The bytes of an XML file, its elements, and the changes to be made.

    Parameters
    ----------
    content
        The file, or one element of a file.
    name
        Its name, for messages.
    """

    def __init__(self, content: bytes, name: str) -> None:
        builder = SpanBuilder()
        parse(io.BytesIO(content), name, builder)
        self.root = builder.close()
        self._content, self._name, self._spans = content, name, builder.spans
        self._changes: list[tuple[int, int, bytes]] = []

    def source(self, element: Element) -> bytes:
        """Return the bytes of an element, as they were."""
        begin, end = self._span(element)
        return self._content[begin:end]

    def set_text(self, element: Element, text: str) -> None:
        """Let an element that holds a text alone hold another one."""
        begin, end = self._span(element)
        tag = _TAG.match(self._content, begin)
        assert tag is not None
        name, rest = tag[1], tag[2].rstrip()
        self._changes.append((begin, end, b"<" + name + rest + b">" + text.encode() + b"</" + name + b">"))

    def set_attribute(self, element: Element, name: str, text: str) -> None:
        """Give an attribute that an element has another value."""
        begin, _ = self._spans[element]
        found = re.compile(rb"\s" + name.encode() + rb"\s*=\s*(\"[^\"]*\"|'[^']*')").search(self._content, begin)
        assert found is not None
        self._changes.append((*found.span(1), b'"' + text.encode() + b'"'))

    def remove(self, element: Element) -> None:
        """Drop an element."""
        self._changes.append((*self._span(element), b""))

    def insert(self, element: Element, made: bytes, *, before: bool = False) -> None:
        """Put bytes behind an element, or before it, with the white space that stands before it."""
        begin, end = self._span(element)
        space = re.search(rb"\s*$", self._content[max(begin - 200, 0) : begin])
        blank = b"" if space is None else space[0]
        at, whole = (begin, made + blank) if before else (end, blank + made)
        self._changes.append((at, at, whole))

    def changed(self) -> bytes:
        """Return the file with all changes."""
        if self._changes and b"\0" in self._content:
            raise InputError(f"{self._name}: expected UTF-8, since it is to be changed, found UTF-16")
        pieces, at = [], 0
        for begin, end, made in sorted(self._changes, key=lambda change: change[:2]):
            pieces += [self._content[at:begin], made]
            at = end
        return b"".join([*pieces, self._content[at:]])

    def _span(self, element: Element) -> tuple[int, int]:
        begin, last = self._spans[element]
        return begin, self._content.index(b">", last) + 1


def child(parent: Element, path: str) -> str | None:
    """Return the text of an element within another, ``None`` where there is none."""
    found = parent.find(path)
    return None if found is None else (found.text or "").strip()
