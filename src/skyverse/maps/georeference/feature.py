"""What the readers of buildings and zones return: outlines on the globe, with altitudes that know their reference."""

from dataclasses import dataclass

from skyverse._typing import Floats
from skyverse.model.altitude import Altitude


@dataclass(frozen=True, eq=False)
class Feature:
    """One building or zone as its file has it; a multipolygon becomes several features.

    Attributes
    ----------
    outline
        (n, 2) WGS84 longitude and latitude, degrees; the first corner is not repeated at the end.
    holes
        The holes' outlines, each (k, 2).
    low, high
        The altitudes at which it begins and ends. ``None`` for `low` means from the ground on, for `high` without end.
    kind
        ``"building"``, or what the file calls the zone.
    solid
        Whether it is a building or another thing, rather than a zone.
    name
        Its name, if it has one.
    where
        File and feature, for messages: ``zones.geojson: feature 3``.
    risk
        The risk of a metre flown inside, for a zone that may be entered; ``None`` for what must not be entered.
    """

    outline: Floats
    holes: tuple[Floats, ...]
    low: Altitude | None
    high: Altitude | None
    kind: str
    solid: bool
    name: str | None
    where: str
    risk: float | None = None
