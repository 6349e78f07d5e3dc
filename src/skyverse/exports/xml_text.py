"""XML documents as text, for the formats that are XML."""

from xml.etree import ElementTree as ET


def add_texts(parent: ET.Element, prefix: str = "", /, **texts: str) -> None:
    """Append elements that contain texts, without the characters that XML cannot contain.

    Parameters
    ----------
    parent
        The element to which they are appended.
    prefix
        What stands before their names, such as ``"gx:"``.
    texts
        The texts by the elements' names.
    """
    for tag, text in texts.items():
        ET.SubElement(parent, prefix + tag).text = "".join(
            c for c in text if c in "\t\n" or ("\x20" <= c <= "\ud7ff") or "\ue000" <= c <= "\ufffd" or c > "\uffff"
        )


def document_text(root: ET.Element) -> str:
    """Return an indented XML document."""
    ET.indent(root, " ")
    return '<?xml version="1.0" encoding="UTF-8"?>\n' + ET.tostring(root, encoding="unicode") + "\n"
