"""Where zones and buildings begin and end, from the many ways in which files say so."""

import math
import re
from collections.abc import Iterator, Mapping
from functools import lru_cache
from typing import Any

from skyverse.errors import InputError
from skyverse.maps.georeference.choices import Choices
from skyverse.model.altitude import FOOT, AboveGround, AboveHome, AboveSea, Altitude, parse_altitude

LOW = ("lowerlimit", "lower", "minaltitude", "minalt", "altitudelower", "loweraltitude", "floor")
HIGH = ("upperlimit", "upper", "maxaltitude", "maxalt", "altitudeupper", "upperaltitude", "ceiling")
_REFERENCE = ("verticalreference", "reference", "referencedatum", "altitudereference", "datum")
_OWN_REFERENCE = ("verticalreference", "verti", "reference", "limitreference", "referencedatum", "altitudereference")
UNIT = ("uomdimensions", "uomdimensi", "uom", "unit", "units", "altitudeunit", "altitudeunits")
_OWN_UNIT = ("uom", "unit", "limituom", "limitunit")
_FRAMES: dict[str, type[AboveSea] | type[AboveHome] | type[AboveGround]] = {
    **dict.fromkeys(("agl", "gnd", "ground", "sfc", "surface", "aboveground", "abovegroundlevel", "hei"), AboveGround),
    **dict.fromkeys(("amsl", "msl", "sea", "abovesealevel", "abovemeansealevel", "alt"), AboveSea),
    **dict.fromkeys(("home", "takeoff", "abovehome"), AboveHome),
}
_UNITS = {
    **dict.fromkeys(("m", "meter", "meters", "metre", "metres"), 1.0),
    **dict.fromkeys(("ft", "foot", "feet"), FOOT),
}
_NUMBER = re.compile(r"\s*([-+]?(?:\d+\.?\d*|\.\d+)(?:e[-+]?\d+)?)\s*([a-z]*)\s*", re.IGNORECASE)


class Properties:
    """A feature's fields, found whatever the case and punctuation of their names."""

    def __init__(self, fields: Mapping[str, Any]) -> None:
        self._fields: dict[str, list[tuple[str, Any]]] = {}
        for name, value in fields.items():
            if not absent(value):
                self._fields.setdefault(plain(name), []).append((name, value))

    def get(self, name: str) -> Any:
        """Return a field's value, or ``None``; of several, the last."""
        return self._fields.get(plain(name), [(name, None)])[-1][1]

    def of(self, *names: str) -> Iterator[tuple[str, Any]]:
        """Return each field that is there, by its own name, and its value."""
        return (field for name in names for field in self._fields.get(name, ()))

    def unread(self, *words: str) -> str | None:
        """Return the first field that holds a number, and any of these words in its name."""
        named = ((name, *one) for name, found in self._fields.items() for one in found)
        return next(
            (
                own
                for name, own, value in named
                if any(word in name for word in words)
                and not isinstance(value, bool)
                and (isinstance(value, int | float) or (isinstance(value, str) and value.strip()[0].isdigit()))
            ),
            None,
        )

    def text(self, *names: str) -> str | None:
        """Return the first of these fields that is a text, in printable characters."""
        for _, value in self.of(*names):
            if isinstance(value, str) and value.strip():
                return printable(value)
        return None


@lru_cache(maxsize=4096)
def plain(name: str) -> str:
    """Return a field's name in lower case, letters and digits only."""
    return re.sub(r"[^a-z0-9]", "", name.lower())


def absent(value: object) -> bool:
    """Tell whether a field holds nothing: null, an empty text, or the NaN of an empty cell."""
    return value is None or (isinstance(value, str) and not value.strip()) or _nan(value)


def _nan(value: object) -> bool:
    return isinstance(value, float) and math.isnan(value)


def printable(text: str) -> str:
    """Return a text on one line, with nothing that a file could not hold."""
    shown = "".join(c if c.isprintable() else " " for c in text.encode("utf-8", "replace").decode())
    return " ".join(shown.split())[:200]


def limits(properties: Properties, where: str, choices: Choices) -> tuple[Altitude | None, Altitude | None, bool]:
    """Return where a zone begins and ends, and whether its file says so at all.

    ``None`` for from the ground on, and for without an upper end.

    Raises
    ------
    InputError
        If a number could be above sea or above ground, or fields contradict one another.
    """
    low, some = _end(properties, "lower", LOW, where, choices)
    high, more = _end(properties, "upper", HIGH, where, choices)
    if low is not None and high is not None and type(low) is type(high) and low.metres >= high.metres:
        raise InputError(
            f"{where}: expected a lower end below the upper end, found {low.metres:g} m and {high.metres:g} m"
        )
    return low, high, some or more


def _end(
    properties: Properties, side: str, names: tuple[str, ...], where: str, choices: Choices
) -> tuple[Altitude | None, bool]:
    found = [(name, _altitude(value, name, side, properties, where, choices)) for name, value in properties.of(*names)]
    if any(other != found[0][1] for _, other in found):
        raise InputError(f"{where}: fields {found[0][0]!r} and {found[1][0]!r} say different things; keep one")
    return (found[0][1], True) if found else (None, False)


def _altitude(
    value: object, field: str, side: str, properties: Properties, where: str, choices: Choices
) -> Altitude | None:
    """Return what one field says; ``None`` for the ground below, or for unlimited above."""
    place = f"{where}: {field!r}"
    if isinstance(value, Mapping):  # such as {"value": 400, "unit": "FT", "referenceDatum": "AGL"}
        properties = Properties({str(name): held for name, held in value.items()})
        value = properties.get("value")
    unit: str | None = None
    if isinstance(value, str):
        if plain(value) in ("gnd", "sfc", "ground", "surface") and side == "lower":
            return None
        if plain(value) in ("unl", "unlimited", "unltd") and side == "upper":
            return None
        written = _NUMBER.fullmatch(value)
        if written is None or (written[2] and written[2].lower() not in _UNITS):
            return _written(value, place)
        value, unit = float(written[1]), written[2].lower() or None
    number = finite(value, place)
    scale = _UNITS[unit] if unit else _scale(properties, side, where, choices, number)
    return _frame(properties, side, place, choices)(number * scale)


def _written(text: str, place: str) -> Altitude:
    try:
        return parse_altitude(text)
    except ValueError as error:
        if re.match(r"\s*FL\s*\d", text, re.IGNORECASE):
            raise InputError(f"{place}: flight levels follow the pressure; give metres or feet amsl") from None
        raise InputError(f"{place}: {error}") from None


def finite(value: object, place: str) -> float:
    """Return a number that a field must hold."""
    if isinstance(value, bool) or not isinstance(value, int | float) or not abs(value) < 1e6:
        raise InputError(f"{place}: expected metres or feet, found {printable(repr(value)):.40}")
    return float(value)


def _scale(properties: Properties, side: str, where: str, choices: Choices, number: float) -> float:
    for field, value in properties.of(*(side + name for name in _OWN_UNIT), *UNIT):
        scale = _UNITS.get(plain(value)) if isinstance(value, str) else None
        if scale is None:
            raise InputError(f"{where}: {field!r}: expected M or FT, found {printable(repr(value)):.40}")
        return scale
    if choices.unit is not None:
        return _UNITS[choices.unit]
    if number != 0:
        choices.tally["limits without a unit taken as metres; --unit ft takes them as feet"] += 1
    return 1.0


def _frame(
    properties: Properties, side: str, place: str, choices: Choices
) -> type[AboveSea] | type[AboveHome] | type[AboveGround]:
    for field, value in properties.of(*(side + name for name in _OWN_REFERENCE), *_REFERENCE):
        frame = _FRAMES.get(plain(value)) if isinstance(value, str) else None
        if frame is None:
            raise InputError(f"{place}: {field!r}: expected AGL or AMSL, found {printable(repr(value)):.40}")
        return frame
    if choices.altitudes is None:
        raise InputError(
            f"{place}: could be above ground or above mean sea level, as the file does not say; "
            "--altitudes agl or --altitudes amsl decides"
        )
    return AboveGround if choices.altitudes == "agl" else AboveSea
