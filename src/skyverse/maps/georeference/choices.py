"""What the user decides where a file leaves it open."""

import math
from collections import Counter
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Literal

from skyverse.errors import InputError

WIDEST = 100_000.0
"""Metres that lines and points may be widened by."""


def _silent(_: str) -> None:
    pass


@dataclass(frozen=True)
class Reading:
    """How files of buildings, zones and points are to be read where they leave it open.

    Attributes
    ----------
    altitudes
        What bare altitudes are counted from: ``"agl"``, the ground, or ``"amsl"``, mean sea level.
    unit
        Of limits of zones, and of points' altitudes, without one, ``"m"`` or ``"ft"``; metres, and told, when left out.
    building_height
        Of buildings that no usable height is given of, metres.
    height_field
        The field that holds the height above ground, where it is none of the usual ones.
    buffer
        How far around lines and points is forbidden, metres.
    crs
        The coordinates of a file that does not say, such as ``"EPSG:2056"``.
    lod
        The level of detail taken from CityJSON, such as ``"1.2"``; each building's highest when left out.
    """

    altitudes: Literal["agl", "amsl"] | None = None
    unit: Literal["m", "ft"] | None = None
    building_height: float | None = None
    height_field: str | None = None
    buffer: float | None = None
    crs: str | None = None
    lod: str | None = None

    def __post_init__(self) -> None:
        if self.altitudes not in (None, "agl", "amsl"):
            raise InputError(f"--altitudes: expected agl (ground) or amsl (mean sea level), found {self.altitudes!r}")
        if self.unit not in (None, "m", "ft"):
            raise InputError(f"--unit: expected m or ft, found {self.unit!r}")
        for name, value in (("--building-height", self.building_height), ("--buffer", self.buffer)):
            if value is not None and not (math.isfinite(value) and value > 0):
                raise InputError(f"{name}: expected metres above zero, found {value}")
        if self.buffer is not None and self.buffer > WIDEST:
            raise InputError(f"--buffer: expected at most {WIDEST:g} metres, found {self.buffer:g}")
        try:
            level = math.isfinite(float(self.lod or 0))
        except ValueError:
            level = False
        if not level:
            raise InputError(f"--lod: expected a level of detail such as 2.2, found {self.lod!r:.40}")


@dataclass(frozen=True)
class Choices(Reading):
    """How one file is to be read, what it is, and who is told of it.

    Attributes
    ----------
    kind
        What all its features are; ``"building"`` ones stand on the ground and need a height. ``None`` for what the
        file says.
    risk
        Of a metre inside, where a feature's field ``risk`` does not say it; ``None`` for what must not be entered,
        whatever such a field says.
    tell
        Is called with a sentence for all that was repaired or left out.
    tally
        What is told once for all of a file, and of how many features it is true.
    """

    kind: str | None = None
    risk: float | None = None
    tell: Callable[[str], object] = _silent
    tally: Counter[str] = field(default_factory=Counter)
