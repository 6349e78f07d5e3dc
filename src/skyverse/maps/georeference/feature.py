"""What readers of buildings and zones hand on: outlines on the globe, with altitudes that know their frame."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from skyverse.model.altitude import Altitude


@dataclass(frozen=True, eq=False)
class Feature:
    """One building or zone as its file has it; a multipolygon is several.

    Attributes
    ----------
    outline
        (n, 2) WGS84 longitude, latitude, degrees; the first corner not repeated.
    holes
        (k, 2) each.
    low, high
        Where it begins and ends; ``None`` for from the ground on, and for without an upper end.
    kind
        ``"building"`` or what its file calls the zone.
    name
        If it has one.
    where
        File and feature, for messages: ``zones.geojson: feature 3``.
    risk
        Of what may be flown through, per metre; ``None`` for what must not be entered.
    """

    outline: NDArray[np.float64]
    holes: tuple[NDArray[np.float64], ...]
    low: Altitude | None
    high: Altitude | None
    kind: str
    name: str | None
    where: str
    risk: float | None = None
