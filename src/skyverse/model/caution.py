"""The words in capitals that mark what a pilot must not overlook, and how to tell what they mark."""

import re
from enum import StrEnum


class Caution(StrEnum):
    """A word in capitals, in a sentence or in a cell of a table, that a pilot must heed; there are no others."""

    WARNING = "WARNING"
    """It begins a sentence that asks for a check or a change before the flight."""
    NOT = "NOT"
    """It stands where a proof fails."""
    ONLY = "ONLY"
    """It stands where a proof has a condition."""


_BEGINS = re.compile(rf"(?:{'|'.join(Caution)})\b")


def stands_out(said: str) -> bool:
    """Tell whether a sentence or a cell begins with a caution, so that it is shown first and marked."""
    return _BEGINS.match(said) is not None
