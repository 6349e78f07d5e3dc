"""The fields of QGroundControl's ``.plan`` that are read, and what they must be."""

from typing import Annotated, Any, Literal, TypeVar

from pydantic import AliasChoices, BaseModel, ConfigDict, Field, ValidationError
from pydantic.alias_generators import to_camel

from skyverse.errors import InputError
from skyverse.model.wrong_values import wrong_field

Number = Annotated[float, Field(strict=True, allow_inf_nan=False)]
Whole = Annotated[int, Field(strict=True, ge=0)]
Flag = Annotated[bool, Field(strict=True)]
Latitude = Annotated[Number, Field(ge=-90, le=90)]
Longitude = Annotated[Number, Field(ge=-180, le=180)]
Corner = tuple[Latitude, Longitude]
Place = tuple[Latitude, Longitude, Number]
Speed = Annotated[Number, Field(gt=0, lt=1e4)]


class _Part(BaseModel):
    """A part of a ``.plan``: the fields that are read."""

    model_config = ConfigDict(alias_generator=to_camel)


class _Polygon(_Part):
    inclusion: Flag
    polygon: Annotated[list[Corner], Field(min_length=3)]


class _Disc(_Part):
    center: Corner
    radius: Annotated[Number, Field(gt=0, lt=1e7)]


class _Circle(_Part):
    inclusion: Flag
    circle: _Disc


class PlanFence(_Part):
    """The geofence."""

    polygons: list[_Polygon] = []
    circles: list[_Circle] = []
    polygon: Any = None
    circle: Any = None


class PlanRally(_Part):
    """The rally points."""

    points: list[Place] = []


class _Mission(_Part):
    version: Literal[2]
    items: list[dict[str, Any]]
    planned_home_position: Annotated[list[Number | None], Field(min_length=2, max_length=3)] | None = None
    firmware_type: Number | None = None
    vehicle_type: Number | None = None
    cruise_speed: Speed | None = None
    hover_speed: Speed | None = None


class Plan(_Part):
    """A whole file."""

    file_type: Literal["Plan"]
    version: Literal[1]
    mission: _Mission
    geo_fence: PlanFence | None = None
    rally_points: PlanRally | None = None


class PlanItem(_Part):
    """What every simple item has."""

    command: Whole
    frame: Whole


class PlanLanding(_Part):
    """A landing pattern, of aeroplanes or VTOLs."""

    land_coordinate: Place
    approach: Annotated[Place, Field(validation_alias=AliasChoices("landingApproachCoordinate", "loiterCoordinate"))]
    loiter_radius: Number
    loiter_clockwise: Flag
    altitudes_are_relative: Flag
    use_loiter_to_alt: Flag = True
    use_do_change_speed: Flag = False
    final_approach_speed: Number = 15.0
    stop_taking_photos: Flag = False
    stop_video_photos: Flag = False


Checked = TypeVar("Checked", bound=_Part)


def checked(kind: type[Checked], data: Any, where: str) -> Checked:
    """Return the fields of a part of a ``.plan``, or raise `InputError` that names the first that is wrong."""
    try:
        return kind.model_validate(data)
    except ValidationError as error:
        raise InputError(": ".join(filter(None, (where, *wrong_field(error, data, set()))))) from None
