"""XML files whose elements are places: found by their names without prefixes, moved, added, and written again."""

import copy
import io
from collections.abc import Callable, Sequence
from xml.etree import ElementTree as ET
from xml.etree.ElementTree import Element

from skyverse.documents.xml import read_tree
from skyverse.orders.places import Step


def root_of(content: bytes, name: str) -> Element:
    """Return the root of a file; `name` is for messages."""
    return read_tree(io.BytesIO(content), name, whole=True)


def local_name(element: Element) -> str:
    """Return the name of an element without its prefix, ``""`` of a comment."""
    return element.tag.rpartition(":")[2] if isinstance(element.tag, str) else ""


def each(parent: Element, name: str) -> list[Element]:
    """Return the elements of a name within another, however deep."""
    return [one for one in parent.iter() if local_name(one) == name]


def find(parent: Element, path: str) -> Element | None:
    """Return the first element at a path of names within another, ``None`` where there is none."""
    found: Element | None = parent
    for name in path.split("/"):
        found = next((one for one in (() if found is None else found) if local_name(one) == name), None)
    return found


def text(parent: Element, path: str) -> str:
    """Return the text of an element within another, ``""`` where there is none."""
    found = find(parent, path)
    return "" if found is None else (found.text or "").strip()


def set_text(parent: Element, path: str, new: str) -> None:
    """Let an element within another, if it is there, hold another text."""
    found = find(parent, path)
    if found is not None:
        found.text = new


def arrange(
    root: Element, holders: Sequence[Element], made: Sequence[Step], put: Callable[[Element, Step], None]
) -> list[Element]:
    """Move and add elements of a file that are places, and return them in their order.

    Parameters
    ----------
    root
        The root of the file.
    holders
        The elements of its places.
    made
        What they shall be.
    put
        Puts a place into an element.
    """
    parents = {one: parent for parent in root.iter() for one in parent}
    copies = {k: copy.deepcopy(holders[step.source]) for k, step in enumerate(made) if step.new}
    arranged: list[Element] = []
    for k, step in enumerate(made):
        own = holders[step.source]
        if step.new:
            around = list(parents[own])
            parents[own].insert(around.index(arranged[-1]) + 1 if arranged else around.index(own), copies[k])
        arranged.append(copies.get(k, own))
        put(arranged[-1], step)
    return arranged


def written_root(root: Element) -> bytes:
    """Return the bytes of a file."""
    content: bytes = ET.tostring(root, encoding="utf-8", xml_declaration=True)
    return content
