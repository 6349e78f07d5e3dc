"""What a pilot must not overlook: the words in capitals that mark it, and the record of what to heed of a mission."""

import re
from dataclasses import dataclass
from enum import StrEnum
from typing import Literal

from skyverse.errors import Remedy, Sentence


class Caution(StrEnum):
    """A word in capitals, in a sentence or in a cell of a table, that a pilot must heed; there are no others."""

    WARNING = "WARNING"
    """It begins a sentence that asks for a check or a change before the flight."""
    NOT = "NOT"
    """It stands where a proof fails."""
    ONLY = "ONLY"
    """It stands where a proof has a condition."""
    BEFORE = "BEFORE"
    """It begins a sentence on what is to be done before each flight."""


NO_UNIT = Sentence(
    f"{Caution.WARNING}: heights without a unit are taken as metres",
    give=[Remedy("Raster.unit", "m", "if they are"), Remedy("Raster.unit", "ft", "to take them as feet")],
)
"""Of a raster."""
_BEGINS = re.compile(rf"(?:{'|'.join(Caution)})\b")


def urgency(said: str) -> int:
    """Return a number by which sentences are sorted: what is not proven, warnings, conditions, what to do, the rest."""
    first = (Caution.NOT, Caution.WARNING, Caution.ONLY, Caution.BEFORE)
    begins = _BEGINS.match(said)
    return first.index(Caution(begins[0])) if begins else len(first)


def stands_out(said: str) -> bool:
    """Tell whether a sentence or a cell begins with a caution, so that it is shown first and marked."""
    return _BEGINS.match(said) is not None


def warning_of(file: str, said: str) -> str:
    """Return a warning on a file, which it names, of a sentence that may be a warning already."""
    begins = f"{Caution.WARNING}: "
    return f"{begins}{file}: {said.removeprefix(begins)}"


@dataclass(frozen=True)
class MissionCaution:
    """What a pilot must heed of a mission, whatever the referee says of it.

    Attributes
    ----------
    kind
        ``"no UAV"`` flies to a target; something of a file was ``"left out"`` or taken for granted; a zone is ``"flown
        over"``; a flight is ``"high"``, higher above ground than most rules allow, or ``"low"``, lower than both of its
        ends over ground of which nobody knows what stands on it; something that a survey asks for is ``"not seen"``; a
        UAV is ``"slow in wind"``, or ``"lands"`` between sorties; a zone or mover ``"comes later"`` to UAVs that stay.
    sentence
        What it is, for people; it begins with a `Caution`.
    names
        The UAVs, targets or files that it is about, where they are known.
    metres
        How high or low; for a zone, how far above its upper end.
    """

    kind: Literal["no UAV", "left out", "flown over", "high", "low", "not seen", "slow in wind", "comes later", "lands"]
    sentence: str
    names: tuple[str, ...] = ()
    metres: float | None = None
