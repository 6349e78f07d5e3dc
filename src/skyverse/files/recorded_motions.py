"""Movers of scenario files whose motion is a recorded track: the track is read, and takes its file's place."""

from pathlib import Path
from typing import Annotated, Any, Literal

from pydantic import BaseModel, Field, ValidationError

from skyverse.errors import InputError, is_number
from skyverse.files.document import explained
from skyverse.maps.readers.track import LONGEST_GAP, recorded_track
from skyverse.maps.readers.track_files import Reference, Unit
from skyverse.model.frame import Frame, Origin
from skyverse.model.quantities import Model, Number, Positive


class RecordedMotion(Model):
    """A recorded track, in scenario files.

    Attributes
    ----------
    track
        A CSV, GPX or JSON file, beside the scenario's.
    altitude, unit, vehicle, zero, gap
        As for `read_track`.
    """

    motion: Literal["track"] = "track"
    track: Annotated[str, Field(min_length=1)]
    altitude: Reference | None = None
    unit: Unit | None = None
    vehicle: str | None = None
    zero: Number | str | None = None
    gap: Positive = LONGEST_GAP


class _Placed(BaseModel):
    """What of a scenario its other files need."""

    frame: Frame = Frame()


def origin_of(source: Path, data: dict[str, Any]) -> Origin | None:
    """Return where the frame of a scenario file's data lies, or raise `InputError`."""
    try:
        return _Placed.model_validate(data).frame.origin
    except ValidationError as error:
        raise explained(source, error, data, set()) from None


def with_recorded_motions(source: Path, data: dict[str, Any]) -> dict[str, Any]:
    """Return the data of a scenario file with each recorded track read, as a motion along waypoints.

    The error that a track states is the radius of its mover's doubt, unless the mover has a doubt of its own. To either
    is added how far off the motion may be because fixes share a second.

    Raises
    ------
    InputError
        If a track cannot be read; the message names both files, and the field.
    """
    movers = data.get("movers")
    if not isinstance(movers, list) or not any(map(_is_recorded, movers)):
        return data
    origin = origin_of(source, data)
    read = []
    for number, mover in enumerate(movers):
        if not _is_recorded(mover):
            read.append(mover)
            continue
        place = f"{source}: movers[{number}].motion"
        try:
            given = RecordedMotion.model_validate(mover["motion"])
        except ValidationError as error:
            raise explained(place, error, mover["motion"], set()) from None
        options = given.model_dump(exclude={"motion", "track"})
        try:
            found = recorded_track(source.parent / given.track, origin, **options)
        except InputError as error:
            raise InputError(f"{place}.track: {error}") from None
        doubt = mover.get("doubt", {"radius": found.error})
        if found.spread and isinstance(doubt, dict) and is_number(radius := doubt.get("radius", 0.0)):
            doubt = {**doubt, "radius": radius + found.spread}
        read.append({**mover, "doubt": doubt, "motion": found.motion})
    return {**data, "movers": read}


def _is_recorded(mover: object) -> bool:
    motion = mover.get("motion") if isinstance(mover, dict) else None
    return isinstance(motion, dict) and ("track" in motion or motion.get("motion") == "track")
