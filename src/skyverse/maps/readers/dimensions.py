"""How high buildings are and how wide circles, from the ways in which files give these lengths and their units."""

import math
import re
from collections.abc import Mapping
from typing import Any

from skyverse.errors import InputError, Remedy, shown
from skyverse.maps.georeference.altitude_limits import GIVE_UNIT, METRES_PER_LIMIT_UNIT, UNIT_FIELDS
from skyverse.maps.georeference.feature import LIMITS, Fields, looked_up, plain
from skyverse.maps.georeference.reading import MAX_BUFFER, Choices
from skyverse.model.altitude import FOOT, AboveGround
from skyverse.model.caution import Caution

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
        others = tags.unread(LIMITS)
        give = [Remedy("Reading.height_field", name) for name in others]
        choices.count_unread(others, "a height", *give, begins=f"{Caution.WARNING}: ")
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


METRES_PER_RADIUS_UNIT = {
    **METRES_PER_LIMIT_UNIT,
    "mtr": 1.0,
    **dict.fromkeys(("km", "kilometer", "kilometers", "kilometre", "kilometres"), 1000.0),
    **dict.fromkeys(("nm", "nmi", "nauticalmile", "nauticalmiles"), 1852.0),
    **dict.fromkeys(("mi", "sm", "mile", "miles", "statutemile", "statutemiles"), 5280 * FOOT),
}
"""By a unit's plain name."""
_UNIT_WORDS = ("unit", "units", "uom", "unitofmeasure", "unitofmeasurement", "uomdimensions")
_RADIUS_UNIT_FIELDS = (
    "unitofradius",
    *(f"radius{word}" for word in _UNIT_WORDS),
    *(f"{word}radius" for word in _UNIT_WORDS),
)
_FIELDS_WITH_UNIT = {
    f"radius{between}{unit}": scale for unit, scale in METRES_PER_RADIUS_UNIT.items() for between in ("", "in")
}
_UNIT_OF_NAME = re.compile(r"[\W_]([a-z]+)\W*$")
"""The unit in a name such as ``buffer_m`` or ``Buffer (km)``."""
_WRITTEN_RADIUS = re.compile(r"\s*(\d+(?:\.\d*)?|\.\d+)\s*([a-z][a-z ]*)?", re.IGNORECASE)


def circle_radius(fields: Fields, where: str, choices: Choices) -> float | None:
    """Return a circle's radius in metres, or ``None`` where its file gives none.

    Its unit stands in the field itself, in the field's name, or in a field beside it, or is the user's. The unit of
    limits counts for the radius where it is metres, or one that limits are not given in, such as kilometres. It does
    not where it is feet: radii beside limits in feet may be in either.

    Raises
    ------
    InputError
        If it is no radius, its unit is not known or not said, or two fields contradict each other.
    """
    found = [(name, _metres(value, name, fields, where, choices)) for name, value in fields.of("radius")]
    for name in choices.radius_fields:
        if (value := fields.get(name)) is not None:
            unit = _UNIT_OF_NAME.search(name.lower())
            scale = METRES_PER_RADIUS_UNIT.get(unit[1]) if unit else None
            metres = (
                _number(value, scale, f"{where}: {name!r}") if scale else _metres(value, name, fields, where, choices)
            )
            found.append((name, metres))
    for name, value in fields.of(*_FIELDS_WITH_UNIT):
        found.append((name, _number(value, _FIELDS_WITH_UNIT[plain(name)], f"{where}: {name!r}")))
    if any(abs(other - found[0][1]) > 1e-6 * other for _, other in found):
        raise InputError(f"{where}: fields {found[0][0]!r} and {found[1][0]!r} say different things; keep one")
    return found[0][1] if found else None


def fields_of_circle(fields: Mapping[str, Any], *left_out: str) -> dict[str, Any]:
    """Return a circle's own fields but some, with its unit under a name that sets it apart from the unit of limits."""
    return {
        f"radius {name}" if plain(name) in UNIT_FIELDS else name: value
        for name, value in fields.items()
        if name not in left_out
    }


def fields_of_standard_circle(circle: Mapping[str, Any], beside: Mapping[str, Any], *left_out: str) -> dict[str, Any]:
    """Return a circle's own fields, for a circle of ED-269 and ED-318, which is in metres where no unit is said.

    Fields `beside` may hold a unit of limits.
    """
    own = any(Fields({**beside, **circle}).of(*_RADIUS_UNIT_FIELDS)) or any(Fields(circle).of(*UNIT_FIELDS))
    shared = (plain(str(said)) not in METRES_PER_LIMIT_UNIT for _, said in Fields(beside).of(*UNIT_FIELDS))
    return fields_of_circle(circle, *left_out) | ({} if own or any(shared) else {"radius unit": "m"})


def _metres(value: object, field: str, fields: Fields, where: str, choices: Choices) -> float:
    place = f"{where}: {field!r}"
    if isinstance(value, Mapping):  # such as {"value": 1.5, "unit": "km"}
        fields = Fields(fields_of_circle({str(name): held for name, held in value.items()}))
        value = fields.get("value")
    written = _WRITTEN_RADIUS.fullmatch(value) if isinstance(value, str) else None
    beside = [(name, _scale(said, f"{where}: {name!r}")) for name, said in fields.of(*_RADIUS_UNIT_FIELDS)]
    if written is not None and written[2]:
        beside.append((field, _scale(written[2], place)))
    if any(scale != beside[0][1] for _, scale in beside):
        raise InputError(f"{where}: fields {beside[0][0]!r} and {beside[-1][0]!r} say different units; keep one")
    if beside:
        return _number(value if written is None else float(written[1]), beside[0][1], place)
    shared = max((_scale(said, f"{where}: {name!r}") for name, said in fields.of(*UNIT_FIELDS)), default=0.0)
    if shared >= 1:
        return _number(value, shared, place)
    if choices.unit is None and length_in_metres(value) is not None:
        raise InputError(f"{place}: could be metres or feet, as the file does not say", give=GIVE_UNIT)
    return _number(value, METRES_PER_LIMIT_UNIT[choices.unit or "m"], place)


def _scale(said: object, place: str) -> float:
    """Return the metres in a unit."""
    return looked_up(METRES_PER_RADIUS_UNIT, said, place, "m, km, ft, NM or mi")


def _number(value: object, scale: float, place: str) -> float:
    number = length_in_metres(value)
    if number is None or not 0 < number * scale <= MAX_BUFFER:
        raise InputError(f"{place}: expected metres above zero, at most {MAX_BUFFER:g}, found {shown(value)}")
    return number * scale
