"""What readers are told of a file that the file does not say itself, and what they return."""

import math
from collections import Counter
from collections.abc import Callable, Collection, Sequence
from dataclasses import dataclass, field
from datetime import datetime
from numbers import Real
from pathlib import Path
from typing import Literal

from skyverse.errors import (
    InputError,
    Remedy,
    Sentence,
    path_of,
    printable,
    require_choice,
    require_kind,
    require_number,
    require_whole,
    shown,
)
from skyverse.model.short_lines import listed

LEAST_BUFFER, MAX_BUFFER = 0.001, 100_000.0
"""The narrowest and the widest band, metres, that may be put around a point or a line."""


@dataclass(frozen=True)
class Raster:
    """A file of ground heights that rasterio can read, and what the file does not say itself.

    Attributes
    ----------
    path
        A GeoTIFF, ASCII grid, .hgt file or another format of rasterio's.
    crs
        The file's coordinate system, such as ``"EPSG:2056"``, where the file does not say it.
    band
        The number of the band that holds the heights, counted from 1; needed where the file has several bands.
    unit
        The unit of the heights, ``"m"``, ``"ft"`` or ``"us-ft"``, in place of the file's own. When left out, heights of
        a file that names no unit are metres, which a caution says, unless its coordinate system is in feet.
    nodata
        The number that stands for no data, in addition to the file's own; ``nan`` says that there is none, and that
        every number is a height.
    """

    path: str | Path
    crs: str | None = None
    band: int | None = None
    unit: str | None = None
    nodata: float | None = None

    def __post_init__(self) -> None:
        path_of(self.path, "Raster.path")
        _require_texts(self, "crs", "unit")
        if self.band is not None:
            require_whole(self.band, "Raster.band", 1)
        if self.nodata is not None and not (isinstance(self.nodata, Real) and math.isnan(self.nodata)):
            require_number(self.nodata, "Raster.nodata", "a number or nan")


@dataclass(frozen=True)
class Reading:
    """How files of buildings, zones and points are read where they leave it open.

    Attributes
    ----------
    altitudes
        What altitudes without a reference are counted from: ``"agl"``, the ground, or ``"amsl"``, mean sea level.
    unit
        The unit, ``"m"`` or ``"ft"``, of zones' limits, buildings' heights and points' altitudes that have none; such
        are refused when it is left out. OpenStreetMap's heights without a unit are always metres.
    maximum_altitudes
        What a zone's maximum altitude or ceiling means that has no lower limit beside it: the altitude up to which
        flight is ``"permitted"``, so that all above is shut, as in the FAA's UAS facility maps, or ``"forbidden"``.
    building_height
        The height, metres, of buildings whose file gives no usable height.
    height_field
        The name of the field that holds the height above ground, where it is none of the usual names.
    radius_field
        The name of the field, or the names of fields, that hold the radius of a point, where it is not ``radius``.
    buffer
        How far around lines and points must not be entered, metres; of a fence, how far UAVs may fly around them.
    crs
        The coordinate system of a file that does not say it, such as ``"EPSG:2056"``.
    lod
        The level of detail taken from CityJSON, such as ``"1.2"``; each building's highest when left out.
    date
        When the mission begins, such as ``"2026-11-26T10:00+01:00"``: zones that are active at times are then so that
        many seconds later, and those that are not within a day are left out. When left out, all are always active.
    """

    altitudes: Literal["agl", "amsl"] | None = None
    unit: Literal["m", "ft"] | None = None
    maximum_altitudes: Literal["permitted", "forbidden"] | None = None
    building_height: float | None = None
    height_field: str | None = None
    radius_field: str | Sequence[str] | None = None
    buffer: float | None = None
    crs: str | None = None
    lod: str | None = None
    date: str | None = None

    def __post_init__(self) -> None:
        words = {"altitudes": ("agl", "amsl"), "unit": ("m", "ft"), "maximum_altitudes": ("permitted", "forbidden")}
        for name, choices in words.items():
            if getattr(self, name) is not None:
                require_choice(getattr(self, name), choices, f"Reading.{name}")
        _require_texts(self, "height_field", "crs")
        if self.radius_field is not None:
            require_kind(self.radius_field, (str, list, tuple), "Reading.radius_field")
        for one in self.radius_fields:
            require_kind(one, str, "Reading.radius_field")
        for name in ("building_height", "buffer"):
            if getattr(self, name) is not None:
                require_number(getattr(self, name), f"Reading.{name}", "metres", LEAST_BUFFER, MAX_BUFFER)
        try:
            level = self.lod is None or (not isinstance(self.lod, bool) and math.isfinite(float(self.lod)))
        except (TypeError, ValueError, OverflowError):
            level = False
        if not level:
            raise InputError(f"expected a level of detail such as 2.2, found {shown(self.lod)}", field="Reading.lod")
        if self.date is not None and instant_of(self.date) is None:
            said = f"expected a date and time with its time zone, as 2026-11-26T10:00+01:00, found {shown(self.date)}"
            raise InputError(said, field="Reading.date")

    @property
    def radius_fields(self) -> tuple[str, ...]:
        """The names of `radius_field`."""
        given = self.radius_field
        return tuple([given] if isinstance(given, str) else given or ())


def instant_of(text: object) -> datetime | None:
    """Return the instant that a date and time with its time zone stands for, or ``None`` for all else."""
    try:
        found = datetime.fromisoformat(text) if isinstance(text, str) else None
    except ValueError:
        return None
    return found if found is not None and found.tzinfo is not None else None


def _require_texts(given: Raster | Reading, *names: str) -> None:
    """Raise `InputError` for one of these fields that is given, but is no text."""
    for name in names:
        if getattr(given, name) is not None:
            require_kind(getattr(given, name), str, f"{type(given).__name__}.{name}")


GIVE_CRS = Remedy("Reading.crs", "EPSG:4326")
"""What helps where a file of buildings, zones or points does not say its coordinate system, with an example."""
GIVE_AMSL = Remedy("Reading.altitudes", "amsl", "to take them as above mean sea level")
"""What helps where a coordinate system does not say what altitudes are counted from."""


@dataclass(frozen=True)
class Choices(Reading):
    """How one file is read, what is in it, and who is told of what was done with it.

    Attributes
    ----------
    kind
        What all features of the file are, such as ``"building"``: buildings stand on the ground and need a height.
        ``None`` where the file says what they are.
    risk
        The risk of a metre flown inside, where a feature's field ``risk`` does not say it. ``None`` for features that
        must not be entered, whatever such a field says.
    tell
        Called with a sentence for each feature that was repaired or left out.
    tally
        How many features each sentence is true of that is told once for the whole file.
    """

    kind: str | None = None
    risk: float | None = None
    tell: Callable[[str], object] = lambda sentence: None
    tally: Counter[Sentence] = field(default_factory=Counter)

    def count(self, text: str, *give: Remedy) -> None:
        """Count one more feature of which a sentence is true, which may begin with a warning; see `tally`."""
        self.tally[Sentence(text, give=give)] += 1

    def count_unread(self, names: Collection[str], what: str, *give: Remedy, begins: str = "") -> None:
        """Count one more feature with fields that look as if they held something, and are not read as that."""
        if names:
            self.count(f"{begins}with {listed([repr(printable(name)) for name in names])}, not read as {what}", *give)
