"""XML documents as text, for the formats that are XML."""

from xml.etree import ElementTree as ET


def add_text(parent: ET.Element, tag: str, text: str) -> None:
    """Append an element that contains `text`, without the characters that XML cannot contain."""
    ET.SubElement(parent, tag).text = "".join(
        c for c in text if c in "\t\n" or ("\x20" <= c <= "\ud7ff") or "\ue000" <= c <= "\ufffd" or c > "\uffff"
    )


def document_text(root: ET.Element) -> str:
    """Return an indented XML document."""
    ET.indent(root, " ")
    return '<?xml version="1.0" encoding="UTF-8"?>\n' + ET.tostring(root, encoding="unicode") + "\n"
