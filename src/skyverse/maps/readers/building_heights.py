"""How high buildings are, from tags such as OpenStreetMap's: height, levels, and where a part begins."""

import math
import re

from skyverse.errors import InputError, Remedy, shown
from skyverse.maps.georeference.altitude_limits import GIVE_UNIT, METRES_PER_LIMIT_UNIT
from skyverse.maps.georeference.choices import Choices
from skyverse.maps.georeference.fields import Fields
from skyverse.model.altitude import FOOT, AboveGround

LEVEL_HEIGHT = 3.0
"""Metres that a level counts for, and a roof whose height and shape are not said."""
HEIGHT_FIELDS = ("height", "buildingheight", "measuredheight", "renderheight", "estheight")
MIN_HEIGHT_FIELDS = ("minheight", "buildingminheight", "renderminheight")
"""Plain names of the fields that hold where a building ends and begins above ground."""
_LENGTH = re.compile(r"(\d+(?:\.\d*)?|\.\d+)\s*(m|metres?|meters?|ft|feet|foot|')?", re.IGNORECASE)
_FEET_AND_INCHES = re.compile(r"(\d+)'\s*(?:(\d+(?:\.\d*)?)(?:\"|''))?")
_MAX_LENGTH = 1e5


def length_in_metres(value: object, unit: float = 1.0) -> float | None:
    """Return a length such as ``10``, ``10.5 m``, ``33 ft``, ``33'`` or ``7'4"`` in metres, or ``None``.

    A number without a unit counts so many of them as `unit` says, in metres.
    """
    number = None
    if isinstance(value, int | float) and not isinstance(value, bool) and abs(value) < _MAX_LENGTH:
        number = float(value) * unit
    elif isinstance(value, str):
        if feet := _FEET_AND_INCHES.fullmatch(value.strip()):
            number = (float(feet[1]) + float(feet[2] or 0) / 12) * FOOT
        elif length := _LENGTH.fullmatch(value.strip()):
            written = 1.0 if (length[2] or "m").lower()[0] == "m" else FOOT
            number = float(length[1]) * (written if length[2] else unit)
    return number if number is None or number < _MAX_LENGTH else None


def number_of_levels(value: object) -> float | None:
    """Return a number of levels, or ``None``; of several, such as ``2;3``, the greatest."""
    if isinstance(value, str):
        numbers = [length_in_metres(part) for part in value.split(";")]
        known = [number for number in numbers if number is not None]
        return max(known) if known and len(known) == len(numbers) and not re.search(r"[a-z']", value) else None
    return length_in_metres(value)


def building_limits(tags: Fields, where: str, choices: Choices) -> tuple[AboveGround | None, AboveGround]:
    """Return where a building begins, ``None`` for the ground, and where it ends.

    Raises
    ------
    InputError
        If nothing usable is said of its height, and `choices` have no height for such buildings, or it has no unit.
    """
    high = _height(tags, where, choices)
    lows = (_length(field, value, where, choices) for field, value in tags.of(*MIN_HEIGHT_FIELDS))
    low = next((metres for metres in lows if metres is not None), None)
    if low is None:
        steps = number_of_levels(tags.get("building:min_level"))
        low = None if steps is None else LEVEL_HEIGHT * steps
    if low is not None and low >= high:
        choices.tell(f"{where}: said to begin at {low:g} m and to end at {high:g} m; taken from the ground on")
        low = None
    return (AboveGround(low) if low and low > 0 else None), AboveGround(high)


def _height(tags: Fields, where: str, choices: Choices) -> float:
    """Return the height above ground at which a building ends, metres."""
    own = choices.height_field
    unread = None
    found: set[float] = set()
    chosen = [(own, tags.get(own))] if own and tags.get(own) is not None else []
    for field, value in [*chosen, *tags.of(*HEIGHT_FIELDS)]:
        height = _length(field, value, where, choices)
        if height is not None and math.isfinite(height) and height > 0:
            if field == own:
                return height
            found.add(height)
        else:
            unread = unread or f"{field!r}: expected a height in metres, found {shown(value)}"
    if len(found) > 1:
        choices.count("with several heights in their fields, of which the greatest is taken")
    if found:
        return max(found)
    number = number_of_levels(tags.get("building:levels"))
    if number is not None and number > 0:
        choices.count("with a height guessed from levels")
        return LEVEL_HEIGHT * number + _roof_height(tags, where, choices)
    if choices.building_height is not None:
        if unread:
            choices.tell(f"{where}: {unread}; taken as {choices.building_height:g} m")
        return choices.building_height
    reason = unread or "expected a height or levels, found neither"
    raise InputError(f"{where}: {reason}", give=[Remedy("Reading.building_height", None, "for buildings without one")])


def _length(field: str, value: object, where: str, choices: Choices) -> float | None:
    """Return a length in metres, or ``None`` where a field holds none; refuse one without a unit that has one."""
    if choices.unit is not None:
        return length_in_metres(value, METRES_PER_LIMIT_UNIT[choices.unit])
    metres = length_in_metres(value)
    if metres != length_in_metres(value, FOOT):
        raise InputError(f"{where}: {field!r}: could be metres or feet, as the file does not say", give=GIVE_UNIT)
    return metres


def _roof_height(tags: Fields, where: str, choices: Choices) -> float:
    height = _length("roof:height", tags.get("roof:height"), where, choices)
    if height is not None and height >= 0:
        return height
    number = number_of_levels(tags.get("roof:levels"))
    if number is not None and number >= 0:
        return LEVEL_HEIGHT * number
    return 0.0 if tags.get("roof:shape") == "flat" else LEVEL_HEIGHT
