"""At which altitudes zones begin and end, from the many ways in which files say so."""

import re
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import replace
from itertools import product
from typing import Any

from skyverse.errors import InputError, Remedy, printable, shown
from skyverse.maps.georeference.feature import Fields, looked_up, number_of, plain
from skyverse.maps.georeference.reading import Choices
from skyverse.model.altitude import FOOT, MAX_WRITTEN, AboveGround, AboveHome, AboveSea, Altitude, parse_altitude

LOWER_FIELDS = ("lowerlimit", "lower", "minaltitude", "minalt", "altitudelower", "loweraltitude", "floor")
UPPER_FIELDS = ("upperlimit", "upper", "maxaltitude", "maxalt", "altitudeupper", "upperaltitude", "ceiling")
"""Plain names of the fields that hold a lower limit, and an upper limit."""
MAXIMUM_FIELDS = ("maxaltitude", "maxalt", "ceiling")
"""Upper limits that, without a lower one, may be the altitude up to which flight is permitted, not forbidden.

Such are the cells of the FAA's UAS facility maps, whose ``CEILING`` is the altitude up to which flight is authorised.
"""
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
_WORDS_OF_UNITS = {*METRES_PER_LIMIT_UNIT, "fl", "level", "levels", "km", "nm", "miles", "pressure"}
"""Words by which several together are a unit, if another than is read, and not the name of an office."""
_WRITTEN_NUMBER = re.compile(r"\s*([-+]?(?:\d+(?:\.\d*)?|\.\d+)(?:e[-+]?\d+)?)\s*([a-z]*)\s*", re.IGNORECASE)
_OPENAIP_UNITS = {0: "m", 1: "ft", 6: None}
_OPENAIP_REFERENCES = {0: "GND", 1: "MSL", 2: "STD"}
"""The numbers that openAIP's airspaces have in place of words, beside a limit's value; 6 are flight levels."""
GIVE_UNIT = (Remedy("Reading.unit", "m"), Remedy("Reading.unit", "ft"))
"""What helps where a file does not say the unit of its altitudes."""
GIVE_ALTITUDES = (Remedy("Reading.altitudes", "agl"), Remedy("Reading.altitudes", "amsl"))
"""What helps where a file does not say what its altitudes are counted from."""
GIVE_MAXIMUM_ALTITUDES = (
    Remedy("Reading.maximum_altitudes", "permitted", "to shut what is above"),
    Remedy("Reading.maximum_altitudes", "forbidden", "to shut what is below"),
)


def altitude_limits(fields: Fields, where: str, choices: Choices) -> tuple[Altitude | None, Altitude | None, bool]:
    """Return the altitudes at which a zone begins and ends, and whether its file says so at all.

    The lower one is ``None`` for from the ground on, the upper one ``None`` for without end.

    Raises
    ------
    InputError
        If a number could be above the sea or above ground, metres or feet, an altitude up to which flight is permitted
        or forbidden, or if fields contradict one another.
    """
    low, has_low = _limit(fields, "lower", LOWER_FIELDS, where, choices)
    high, has_high = _limit(fields, "upper", UPPER_FIELDS, where, choices)
    if not has_low and (name := _maximum(fields)) is not None:
        if choices.maximum_altitudes is None:
            raise InputError(
                f"{where}: {name!r}: without a lower limit, it could be the altitude up to which flight is permitted, "
                "as in the FAA's UAS facility maps, or forbidden",
                give=GIVE_MAXIMUM_ALTITUDES,
            )
        if choices.maximum_altitudes == "permitted":
            low, high = high, None
    low, high = from_the_ground(low, high, choices)
    if low is not None and high is not None and type(low) is type(high) and low.metres >= high.metres:
        raise InputError(
            f"{where}: expected a lower end below the upper end, found {low.metres:g} m and {high.metres:g} m"
        )
    return low, high, has_low or has_high


def permitted_height(fields: Fields, where: str, choices: Choices) -> AboveGround:
    """Return the height above ground up to which flight is permitted, which a file must say and nothing else.

    Raises
    ------
    InputError
        If it says no such height, one that could be metres or feet, or a lower limit.
    """
    permitted = replace(choices, altitudes="agl", maximum_altitudes="permitted")
    low, _, _ = altitude_limits(fields, where, permitted)
    found = _maximum(fields)
    if found is None or any(fields.of(*LOWER_FIELDS)) or not isinstance(low, AboveGround) or low.metres < 0:
        said = "none" if found is None else f"{found!r}, {shown(fields.get(found))}, which is none or not alone"
        raise InputError(f"{where}: expected a permitted height above ground, as CEILING or max_altitude, found {said}")
    return low


def from_the_ground(
    low: Altitude | None, high: Altitude | None, choices: Choices
) -> tuple[Altitude | None, Altitude | None]:
    """Return the limits of a zone, without any for one that would end at or below the ground it begins at.

    Such an upper limit stands for a missing one, and the zone is shut as one that names none.
    """
    begins_on_ground = low is None or (isinstance(low, AboveGround) and low.metres <= 0)
    if not (begins_on_ground and isinstance(high, AboveGround) and high.metres <= 0):
        return low, high
    what = "shut" if choices.risk is None else "risky"
    choices.count(f"with an upper limit at or below the ground, which is none: {what} from the ground up")
    return None, None


def _maximum(fields: Fields) -> str | None:
    """Return the name of the field that holds the upper limit, where only fields of `MAXIMUM_FIELDS` do."""
    names = [name for name, _ in fields.of(*UPPER_FIELDS)]
    return names[0] if names and all(plain(name) in MAXIMUM_FIELDS for name in names) else None


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
        beside = [Fields(_in_words({str(name): held for name, held in value.items()})), fields]
        value = beside[0].get("value")
    unit: str | None = None
    if isinstance(value, str):
        if plain(value) in ("gnd", "sfc", "ground", "surface"):
            return None if side == "lower" else AboveGround(0.0)
        if plain(value) in ("unl", "unlimited", "unltd") and side == "upper":
            return None
        written = _WRITTEN_NUMBER.fullmatch(value) if len(value) <= MAX_WRITTEN else None
        if written is None or (written[2] and written[2].lower() not in METRES_PER_LIMIT_UNIT):
            return _parsed(value, place, _unit_beside(beside, side, where, choices))
        value, unit = float(written[1]), written[2].lower() or None
    number = number_of(value, place)
    reference = _reference(beside, side, place, choices)
    scale = METRES_PER_LIMIT_UNIT[unit] if unit else _scale(beside, side, place, where, choices, number)
    return reference(number * scale)


def _in_words(said: dict[str, Any]) -> dict[str, Any]:
    """Return an altitude's fields with words in place of openAIP's numbers, where all of them are such."""
    unit, reference = said.get("unit"), said.get("referenceDatum")
    if type(unit) is int and type(reference) is int and unit in _OPENAIP_UNITS and reference in _OPENAIP_REFERENCES:
        words = {"unit": _OPENAIP_UNITS[unit], "referenceDatum": _OPENAIP_REFERENCES[reference]}
        return {**said, **words, "value": f"FL{said.get('value')}" if unit == 6 else said.get("value")}
    return said


def _parsed(text: str, place: str, unit: float | None) -> Altitude:
    try:
        return parse_altitude(text, unit)
    except ValueError as error:
        if re.match(r"\s*FL\s*\d", text, re.IGNORECASE):
            raise InputError(f"{place}: flight levels follow the pressure; give metres or feet amsl") from None
        give = GIVE_UNIT if "in m or ft" in str(error) else ()
        raise InputError(f"{place}: {error}", give=give) from None


def _of(beside: Iterable[Fields], names: tuple[str, ...]) -> Iterator[tuple[str, object]]:
    """Return the fields of these names, those beside a limit's own value first."""
    return (field for fields in beside for field in fields.of(*names))


def _unit_beside(beside: Iterable[Fields], side: str, where: str, choices: Choices) -> float | None:
    """Return the metres in the unit that stands beside one limit, or that the user gives; ``None`` for neither."""
    for field, value in _of(beside, _UNITS_BESIDE[side]):
        words = {plain(word) for word in value.split()} if isinstance(value, str) else set()
        if len(words) < 2 or words & _WORDS_OF_UNITS:
            return looked_up(METRES_PER_LIMIT_UNIT, value, f"{where}: {field!r}", "M or FT")
        if choices.unit is None:
            raise InputError(f"{where}: {field!r}: expected M or FT, found {shown(value)}", give=GIVE_UNIT)
        choices.count(f"with {printable(field)!r}, which holds no unit")
    return None if choices.unit is None else METRES_PER_LIMIT_UNIT[choices.unit]


def _scale(beside: Iterable[Fields], side: str, place: str, where: str, choices: Choices, number: float) -> float:
    """Return the metres in a unit of one limit; nought needs none."""
    unit = _unit_beside(beside, side, where, choices)
    if unit is None and number != 0:
        raise InputError(f"{place}: could be metres or feet, as the file does not say", give=GIVE_UNIT)
    return unit or 1.0


def _reference(beside: Iterable[Fields], side: str, place: str, choices: Choices) -> Reference:
    """Return what one limit is counted from."""
    for field, value in _of(beside, _REFERENCES_BESIDE[side]):
        return looked_up(_REFERENCES, value, f"{place}: {field!r}", "AGL or AMSL")
    if choices.altitudes is None:
        raise InputError(
            f"{place}: could be above ground or above mean sea level, as the file does not say", give=GIVE_ALTITUDES
        )
    return AboveGround if choices.altitudes == "agl" else AboveSea
