"""The radius of a circle around a point, from the ways in which files give it and its unit."""

import re
from collections.abc import Mapping
from typing import Any

from skyverse.errors import InputError, shown
from skyverse.maps.georeference.altitude_limits import GIVE_UNIT, METRES_PER_LIMIT_UNIT, UNIT_FIELDS
from skyverse.maps.georeference.choices import MAX_BUFFER, Choices
from skyverse.maps.georeference.fields import Fields, looked_up, plain
from skyverse.maps.readers.building_heights import length_in_metres
from skyverse.model.altitude import FOOT

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
