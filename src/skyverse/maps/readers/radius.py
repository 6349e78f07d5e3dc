"""The radius of a circle around a point, from the ways in which files give it and its unit."""

import re
from collections.abc import Mapping
from typing import Any

from skyverse.errors import InputError
from skyverse.maps.georeference.choices import WIDEST, Choices
from skyverse.maps.georeference.limits import UNIT, Properties, plain, printable
from skyverse.maps.readers.heights import metres
from skyverse.model.altitude import FOOT

UNITS = {
    **dict.fromkeys(("m", "meter", "meters", "metre", "metres", "mtr"), 1.0),
    **dict.fromkeys(("km", "kilometer", "kilometers", "kilometre", "kilometres"), 1000.0),
    **dict.fromkeys(("ft", "foot", "feet"), FOOT),
    **dict.fromkeys(("nm", "nmi", "nauticalmile", "nauticalmiles"), 1852.0),
    **dict.fromkeys(("mi", "sm", "mile", "miles", "statutemile", "statutemiles"), 5280 * FOOT),
}
"""Metres to each, by its plain name."""
_WORDS = ("unit", "units", "uom", "unitofmeasure", "unitofmeasurement", "uomdimensions")
_OWN = ("unitofradius", *(f"radius{word}" for word in _WORDS), *(f"{word}radius" for word in _WORDS))
_NAMED = {f"radius{between}{unit}": scale for unit, scale in UNITS.items() for between in ("", "in")}
_NUMBER = re.compile(r"\s*(\d+\.?\d*|\.\d+)\s*([a-z][a-z ]*)?", re.IGNORECASE)


def radius(properties: Properties, where: str, choices: Choices) -> float | None:
    """Return metres, or ``None`` where there is no radius.

    Its unit is in the field itself, in its name, or in a field beside it; metres where nothing says so. What is said of
    limits counts for it only where limits are not given so, as in kilometres.

    Raises
    ------
    InputError
        If it is no radius, its unit is not known, or it is said twice and not alike.
    """
    found = [(name, _metres(value, name, properties, where, choices)) for name, value in properties.of("radius")]
    for name, value in properties.of(*_NAMED):
        found.append((name, _number(value, _NAMED[plain(name)], f"{where}: {name!r}")))
    if any(abs(other - found[0][1]) > 1e-6 * other for _, other in found):
        raise InputError(f"{where}: fields {found[0][0]!r} and {found[1][0]!r} say different things; keep one")
    return found[0][1] if found else None


def of_circle(fields: Mapping[str, Any], *left: str) -> dict[str, Any]:
    """Return a circle's own fields, with what is said of its unit kept apart from that of limits."""
    return {
        f"radius {name}" if plain(name) in UNIT else name: value for name, value in fields.items() if name not in left
    }


def _metres(value: object, field: str, properties: Properties, where: str, choices: Choices) -> float:
    place = f"{where}: {field!r}"
    if isinstance(value, Mapping):  # such as {"value": 1.5, "unit": "km"}
        properties = Properties(of_circle({str(name): held for name, held in value.items()}))
        value = properties.get("value")
    written = _NUMBER.fullmatch(value) if isinstance(value, str) else None
    beside = [(name, _scale(said, f"{where}: {name!r}")) for name, said in properties.of(*_OWN)]
    if written is not None and written[2]:
        beside.append((field, _scale(written[2], place)))
    if any(scale != beside[0][1] for _, scale in beside):
        raise InputError(f"{where}: fields {beside[0][0]!r} and {beside[-1][0]!r} say different units; keep one")
    if beside:
        return _number(value if written is None else float(written[1]), beside[0][1], place)
    scale = 1.0
    for name, said in properties.of(*UNIT):
        shared = _scale(said, f"{where}: {name!r}")
        scale = max(scale, shared)
        if shared < 1:
            choices.tally["with a radius taken as metres, though limits are in feet; a field radiusUnit decides"] += 1
    return _number(value, scale, place)


def _scale(said: object, place: str) -> float:
    scale = UNITS.get(plain(said)) if isinstance(said, str) else None
    if scale is None:
        raise InputError(f"{place}: expected m, km, ft, NM or mi, found {printable(repr(said)):.40}")
    return scale


def _number(value: object, scale: float, place: str) -> float:
    number = metres(value)
    if number is None or not 0 < number * scale <= WIDEST:
        raise InputError(f"{place}: expected metres above zero, at most {WIDEST:g}, found {printable(repr(value)):.40}")
    return number * scale
