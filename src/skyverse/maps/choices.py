"""What the user decides where a file of buildings or zones leaves it open."""

import math
from collections import Counter
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Literal

from skyverse.errors import InputError


def _silent(_: str) -> None:
    pass


@dataclass(frozen=True)
class Choices:
    """How a file is to be read.

    Attributes
    ----------
    kind
        What all its features are; ``"building"`` ones stand on the ground and need a height. ``None`` for what the
        file says.
    altitudes
        What bare altitudes are counted from: ``"agl"``, the ground, or ``"amsl"``, mean sea level.
    unit
        Of limits of zones without one, ``"m"`` or ``"ft"``; metres, and told, when left out.
    height
        Of buildings that no usable height is given of, metres.
    height_field
        The field that holds the height above ground, where it is none of the usual ones.
    buffer
        How far around lines and points is forbidden, metres.
    crs
        The coordinates of a file that does not say, such as ``"EPSG:2056"``.
    lod
        The level of detail taken from CityJSON; ``None`` for each building's highest.
    risk
        Of a metre inside, where a feature has no field that says it; ``None`` for what must not be entered.
    tell
        Is called with a sentence for all that was repaired or left out.
    tally
        What is told once for all of a file, and of how many features it is true.
    """

    kind: str | None = None
    altitudes: Literal["agl", "amsl"] | None = None
    height: float | None = None
    height_field: str | None = None
    buffer: float | None = None
    crs: str | None = None
    lod: str | None = None
    risk: float | None = None
    unit: Literal["m", "ft"] | None = None
    tell: Callable[[str], object] = _silent
    tally: Counter[str] = field(default_factory=Counter)

    def __post_init__(self) -> None:
        if self.altitudes not in (None, "agl", "amsl"):
            raise InputError(f"--altitudes: expected agl (ground) or amsl (mean sea level), found {self.altitudes!r}")
        if self.unit not in (None, "m", "ft"):
            raise InputError(f"--unit: expected m or ft, found {self.unit!r}")
        for name, value in (("--building-height", self.height), ("--buffer", self.buffer)):
            if value is not None and not (math.isfinite(value) and value > 0):
                raise InputError(f"{name}: expected metres above zero, found {value}")
        try:
            level = math.isfinite(float(self.lod or 0))
        except ValueError:
            level = False
        if not level:
            raise InputError(f"--lod: expected a level of detail such as 2.2, found {self.lod!r:.40}")
