"""At which altitudes zones begin and end, from the many ways in which files say so."""

import re
from collections.abc import Iterable, Iterator, Mapping
from itertools import product

from skyverse.errors import InputError, Remedy
from skyverse.maps.georeference.choices import Choices
from skyverse.maps.georeference.fields import Fields, looked_up, number_of, plain
from skyverse.model.altitude import FOOT, MAX_WRITTEN, AboveGround, AboveHome, AboveSea, Altitude, parse_altitude

LOWER_FIELDS = ("lowerlimit", "lower", "minaltitude", "minalt", "altitudelower", "loweraltitude", "floor")
UPPER_FIELDS = ("upperlimit", "upper", "maxaltitude", "maxalt", "altitudeupper", "upperaltitude", "ceiling")
"""Plain names of the fields that hold a lower limit, and an upper limit."""
_UNIT_WORDS = ("uomdimensions", "uomdimensi", "uom", "unit", "units", "unitofmeasure", "unitofmeasurement")
_REFERENCE_FIELDS = ("verticalreference", "reference", "referencedatum", "altitudereference", "datum")


def _joined(names: Iterable[str], words: Iterable[str]) -> tuple[str, ...]:
    """Return the plain names of fields made of a name and a word, in either order: ``loweruom``, ``uomlower``."""
    return tuple(joined for name, word in product(names, words) for joined in (name + word, word + name))


UNIT_FIELDS = (*_UNIT_WORDS, *_joined(("altitude", "altitudes", "limit", "limits", "vertical"), _UNIT_WORDS))
"""Plain names of the fields that hold the unit of both limits."""
_UNITS_BESIDE = {
    "lower": (*_joined(LOWER_FIELDS, _UNIT_WORDS), *UNIT_FIELDS),
    "upper": (*_joined(UPPER_FIELDS, _UNIT_WORDS), *UNIT_FIELDS),
}
_REFERENCES_BESIDE = {
    "lower": (*_joined(LOWER_FIELDS, (*_REFERENCE_FIELDS, "verti", "ref")), *_REFERENCE_FIELDS),
    "upper": (*_joined(UPPER_FIELDS, (*_REFERENCE_FIELDS, "verti", "ref")), *_REFERENCE_FIELDS),
}
"""By limit, the fields that hold its unit and its reference: its own before those of both limits."""
Reference = type[AboveSea] | type[AboveHome] | type[AboveGround]
_REFERENCES: dict[str, Reference] = {
    **dict.fromkeys(("agl", "gnd", "ground", "sfc", "surface", "aboveground", "abovegroundlevel", "hei"), AboveGround),
    **dict.fromkeys(("amsl", "msl", "sea", "abovesealevel", "abovemeansealevel", "alt"), AboveSea),
    **dict.fromkeys(("home", "takeoff", "abovehome"), AboveHome),
}
METRES_PER_LIMIT_UNIT = {
    **dict.fromkeys(("m", "meter", "meters", "metre", "metres"), 1.0),
    **dict.fromkeys(("ft", "foot", "feet"), FOOT),
}
"""By a unit's plain name."""
_WRITTEN_NUMBER = re.compile(r"\s*([-+]?(?:\d+(?:\.\d*)?|\.\d+)(?:e[-+]?\d+)?)\s*([a-z]*)\s*", re.IGNORECASE)
GIVE_ALTITUDES = (Remedy("Reading.altitudes", "agl"), Remedy("Reading.altitudes", "amsl"))
"""What helps where a file does not say what its altitudes are counted from."""


def altitude_limits(fields: Fields, where: str, choices: Choices) -> tuple[Altitude | None, Altitude | None, bool]:
    """Return the altitudes at which a zone begins and ends, and whether its file says so at all.

    The lower one is ``None`` for from the ground on, the upper one ``None`` for without end.

    Raises
    ------
    InputError
        If a number could be above the sea or above ground, or fields contradict one another.
    """
    low, has_low = _limit(fields, "lower", LOWER_FIELDS, where, choices)
    high, has_high = _limit(fields, "upper", UPPER_FIELDS, where, choices)
    if low is not None and high is not None and type(low) is type(high) and low.metres >= high.metres:
        raise InputError(
            f"{where}: expected a lower end below the upper end, found {low.metres:g} m and {high.metres:g} m"
        )
    return low, high, has_low or has_high


def _limit(
    fields: Fields, side: str, names: tuple[str, ...], where: str, choices: Choices
) -> tuple[Altitude | None, bool]:
    found = [(name, _altitude(value, name, side, fields, where, choices)) for name, value in fields.of(*names)]
    if any(other != found[0][1] for _, other in found):
        raise InputError(f"{where}: fields {found[0][0]!r} and {found[1][0]!r} say different things; keep one")
    return (found[0][1], True) if found else (None, False)


def _altitude(value: object, field: str, side: str, fields: Fields, where: str, choices: Choices) -> Altitude | None:
    """Return the altitude in one field; ``None`` for the ground below, or for unlimited above."""
    place = f"{where}: {field!r}"
    beside = [fields]
    if isinstance(value, Mapping):  # such as {"value": 400, "unit": "FT", "referenceDatum": "AGL"}
        beside = [Fields({str(name): held for name, held in value.items()}), fields]
        value = beside[0].get("value")
    unit: str | None = None
    if isinstance(value, str):
        if plain(value) in ("gnd", "sfc", "ground", "surface") and side == "lower":
            return None
        if plain(value) in ("unl", "unlimited", "unltd") and side == "upper":
            return None
        written = _WRITTEN_NUMBER.fullmatch(value) if len(value) <= MAX_WRITTEN else None
        if written is None or (written[2] and written[2].lower() not in METRES_PER_LIMIT_UNIT):
            return _parsed(value, place, _unit_beside(beside, side, where, choices))
        value, unit = float(written[1]), written[2].lower() or None
    number = number_of(value, place)
    scale = METRES_PER_LIMIT_UNIT[unit] if unit else _scale(beside, side, where, choices, number)
    return _reference(beside, side, place, choices)(number * scale)


def _parsed(text: str, place: str, unit: float | None) -> Altitude:
    try:
        return parse_altitude(text, unit)
    except ValueError as error:
        if re.match(r"\s*FL\s*\d", text, re.IGNORECASE):
            raise InputError(f"{place}: flight levels follow the pressure; give metres or feet amsl") from None
        give = [Remedy("Reading.unit", "ft", "to take it as feet")] if "in m or ft" in str(error) else []
        raise InputError(f"{place}: {error}", give=give) from None


def _of(beside: Iterable[Fields], names: tuple[str, ...]) -> Iterator[tuple[str, object]]:
    """Return the fields of these names, those beside a limit's own value first."""
    return (field for fields in beside for field in fields.of(*names))


def _unit_beside(beside: Iterable[Fields], side: str, where: str, choices: Choices) -> float | None:
    """Return the metres in the unit that stands beside one limit, or that the user gives; ``None`` for neither."""
    for field, value in _of(beside, _UNITS_BESIDE[side]):
        return looked_up(METRES_PER_LIMIT_UNIT, value, f"{where}: {field!r}", "M or FT")
    return None if choices.unit is None else METRES_PER_LIMIT_UNIT[choices.unit]


def _scale(beside: Iterable[Fields], side: str, where: str, choices: Choices, number: float) -> float:
    """Return the metres in a unit of one limit."""
    unit = _unit_beside(beside, side, where, choices)
    if unit is not None:
        return unit
    if number != 0:
        choices.count("limits without a unit taken as metres", Remedy("Reading.unit", "ft", "to take them as feet"))
    return 1.0


def _reference(beside: Iterable[Fields], side: str, place: str, choices: Choices) -> Reference:
    """Return what one limit is counted from."""
    for field, value in _of(beside, _REFERENCES_BESIDE[side]):
        return looked_up(_REFERENCES, value, f"{place}: {field!r}", "AGL or AMSL")
    if choices.altitudes is None:
        raise InputError(
            f"{place}: could be above ground or above mean sea level, as the file does not say", give=GIVE_ALTITUDES
        )
    return AboveGround if choices.altitudes == "agl" else AboveSea
