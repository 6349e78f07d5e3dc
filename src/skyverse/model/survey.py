"""Surveys: what a camera is to see, how finely and with what overlap, and in which pattern it is flown."""

import re
from itertools import pairwise
from typing import Annotated, Any, Literal, Self

import numpy as np
from pydantic import AfterValidator, BeforeValidator, Field, field_validator, model_validator

from skyverse.errors import require_kind
from skyverse.model.camera import Camera, camera_of
from skyverse.model.coverage import Coverage
from skyverse.model.quantities import Model, NonNegative, Number, Place, Point, Positive, listed
from skyverse.model.shapes import Region

Pattern = Literal["strips", "cross", "oblique", "corridor", "facade", "viewpoints", "orbit"]
Trigger = Literal["distance", "time", "point"]

OF_AREAS: tuple[Pattern, ...] = ("strips", "cross", "oblique")
"""The patterns over areas."""
OF_STRUCTURES: tuple[Pattern, ...] = ("facade", "viewpoints", "orbit")
"""The patterns around structures."""
GIMBAL: dict[Pattern, float] = {"oblique": -45.0, "facade": 0.0, "viewpoints": 0.0, "orbit": -20.0}
"""Degrees above the horizon at which a pattern's camera looks unless a survey says it; straight down elsewhere."""
_METRES = {"mm": 1e-3, "cm": 1e-2, "m": 1.0}
_LENGTH = re.compile(r"\s*(\d+(?:\.\d*)?|\.\d+)\s*(mm|cm|m)\s*(?:/\s*px)?\s*")


def _metres(given: object) -> object:
    """Return a length that is written with its unit in metres, and anything else as it is."""
    if not isinstance(given, str):
        return given
    match = _LENGTH.fullmatch(given[:40])
    if match is None:
        raise ValueError("expected a length with its unit, such as '2 cm'")
    return float(match[1]) * _METRES[match[2]]


def _regions(given: object) -> object:
    """Return one region, or the corners of one, as an area of one region, and anything else as it is."""
    if isinstance(given, Region | dict):
        return (given,)
    rows = listed(given)
    if isinstance(rows, list | tuple) and rows and isinstance(rows[0], list | tuple | np.ndarray):
        return ({"vertices": rows},)
    return rows


Area = Annotated[tuple[Region, ...], BeforeValidator(_regions)]
Facet = Annotated[tuple[Point, Point, Point], BeforeValidator(listed)]


def _no_share(percent: float) -> float:
    """Refuse what is rather a share of 1 than per cent."""
    if 0 < percent < 1:
        raise ValueError(f"expected per cent, such as 80, found {percent:g}, which is less than one per cent")
    return percent


Percent = Annotated[Number, Field(ge=0, le=95), AfterValidator(_no_share)]


class Survey(Model):
    """What a camera is to see, and how: photos of an area, along a line, or of structures.

    Attributes
    ----------
    name
        Unique in its scenario; ``survey-1`` and so on if it is left out.
    area
        The parts of what is to be seen of the ground, for the patterns ``"strips"``, ``"cross"`` and ``"oblique"``; one
        part may be given as its corners alone.
    line, width
        x, y of the points of a line, metres, and how broad the ground along it is that is to be seen: a corridor.
    structures
        The names of obstacles whose walls are to be seen, as far as they are above the ground; roofs are not.
    facets
        Triangles of a structure to be seen, corners x, y, z in metres, counterclockwise as seen from outside.
    camera
        The camera, or the name of one of `CAMERAS`.
    gsd
        The ground sample distance at most, metres, or text with a unit such as ``"2 cm"``.
    height
        Metres from the camera to what it sees, instead: above ground, or from a wall.
    gsd_of
        Where the ground sample distance is kept: ``"photo"``, all over each photo's part of the area, or ``"place"``,
        in the photos that are taken nearest to each place, which on slopes of 30 degrees takes about 0.6 of them. If it
        is left out, ``"photo"`` where the camera looks straight down at the ground, else ``"place"``.
    overlap
        Per cent that photos share with the one before on their strip, and with those of the strip beside it, at least:
        the area, on a map, of the ground to be seen that both show, as a share of what that one shows which shows less.
    pattern
        ``"strips"``; ``"cross"``, strips in two directions; ``"oblique"``, strips straight down and slanting in four
        directions; ``"corridor"``; ``"facade"``, layers around structures; ``"viewpoints"``, as few photos of them as
        possible; ``"orbit"``, circles around them.
    direction
        Of strips, degrees clockwise from north; the best one, or several, if it is left out.
    gimbal
        Degrees above the horizon at which the camera looks, -90 straight down; as the pattern needs if it is left out.
    trigger
        What autopilots take photos by: ``"distance"`` flown, ``"time"``, or at each ``"point"``, standing still.
    margin
        Metres beyond the area that are seen as well.
    uavs
        The names of the UAVs that fly it; empty for all.
    """

    name: str = ""
    area: Area = ()
    line: Annotated[tuple[Place, ...], BeforeValidator(listed)] = ()
    width: Positive | None = None
    structures: tuple[str, ...] = ()
    facets: Annotated[tuple[Facet, ...], BeforeValidator(listed)] = ()
    camera: Annotated[Camera, BeforeValidator(camera_of, json_schema_input_type=Camera | str)]
    gsd: Annotated[
        Annotated[Number, Field(ge=2e-4, le=1)] | None,
        BeforeValidator(_metres, json_schema_input_type=float | str | None),
    ] = None
    height: Annotated[Positive | None, BeforeValidator(_metres, json_schema_input_type=float | str | None)] = None
    gsd_of: Literal["photo", "place"] | None = None
    overlap: Annotated[tuple[Percent, Percent], BeforeValidator(listed)] = (80.0, 70.0)
    pattern: Pattern = "strips"
    direction: Annotated[Number, Field(ge=0, le=360)] | None = None
    gimbal: Annotated[Number, Field(ge=-90, le=30)] | None = None
    trigger: Trigger = "distance"
    margin: NonNegative = 0.0
    uavs: tuple[str, ...] = ()

    def __init__(self, area: object = None, camera: object = None, /, **data: Any) -> None:
        given = {"area": area, "camera": camera}
        super().__init__(**{name: value for name, value in given.items() if value is not None}, **data)

    __init__.__pydantic_base_init__ = True  # type: ignore[attr-defined]  # as of Model

    @field_validator("line")
    @classmethod
    def _leads_on(cls, line: tuple[Place, ...]) -> tuple[Place, ...]:
        if len(line) == 1 or any(a == b for a, b in pairwise(line)):
            raise ValueError("expected two points or more, no two alike one after the other")
        return line

    @model_validator(mode="after")
    def _whole(self) -> Self:
        if (self.gsd is None) == (self.height is None):
            raise ValueError(f"give gsd or height; {'both' if self.height else 'neither'} is given")
        needed = {"area": self.pattern in OF_AREAS, "line": self.pattern == "corridor"}
        needed["width"] = needed["line"]
        given = {name: bool(getattr(self, name)) for name in needed}
        needed["structures or facets"] = not self.of_ground
        given["structures or facets"] = bool(self.structures or self.facets)
        for name, needs in needed.items():
            if given[name] != needs:
                raise ValueError(f"pattern {self.pattern!r} {'needs' if needs else 'has no'} {name}")
        return self

    def without(self, coverage: Coverage, direction: float | None = None) -> "tuple[Survey, ...]":
        """Return surveys of what is missing, with the same camera, distance and overlap; none if nothing is.

        Parameters
        ----------
        coverage
            What was seen of it, as `check_photos` judges it.
        direction
            Of strips, degrees clockwise from north, as in `Photos.direction` of those that were taken, whose neighbours
            they then are; that of the survey, or north, if it is left out.
        """
        require_kind(coverage, Coverage, "coverage")
        from skyverse.model.missing import boxes_of, facets_of  # shapely loads only where it is needed

        given = {name: getattr(self, name) for name in type(self).model_fields}
        if not self.of_ground:
            facets = facets_of(coverage)
            again = given | {"structures": (), "facets": facets, "pattern": "viewpoints"}
            return (type(self)(**again),) if facets else ()
        given |= {"pattern": "strips", "line": (), "width": None} if self.line else {}
        given |= {"margin": 0.0, "direction": direction if direction is not None else self.direction or 0.0}
        near = (1 - self.overlap[0] / 100) * self.distance * self.camera.half_widths[1]
        boxes = boxes_of(coverage, given["direction"], near) if coverage.gaps else []
        name = f"{self.name or 'survey'} again"
        return tuple(
            type(self)(**given | {"area": box.tolist(), "name": f"{name} {k}"}) for k, box in enumerate(boxes, 1)
        )

    @property
    def distance(self) -> float:
        """Metres from the camera to what it sees, at most where a ground sample distance is given."""
        return self.camera.distance(self.gsd) if self.gsd is not None else float(self.height or 0.0)

    @property
    def pitch(self) -> float:
        """Degrees above the horizon at which the camera looks."""
        return GIMBAL.get(self.pattern, -90.0) if self.gimbal is None else self.gimbal

    @property
    def fine_all_over(self) -> bool:
        """Whether the ground sample distance is kept all over each photo."""
        straight_down = self.of_ground and self.pitch == -90.0
        return self.gsd is not None and (self.gsd_of or ("photo" if straight_down else "place")) == "photo"

    @property
    def of_ground(self) -> bool:
        """Whether it is the ground that is to be seen."""
        return self.pattern not in OF_STRUCTURES

    @property
    def overlaps_on_walls(self) -> bool:
        """Whether photos of walls are to overlap, which no proof tells."""
        return self.pattern in ("facade", "orbit") and max(self.overlap) > 0
