"""How high buildings are, from tags such as OpenStreetMap's: height, levels, and where a part begins."""

import math
import re

from skyverse.errors import InputError
from skyverse.maps.georeference.choices import Choices
from skyverse.maps.georeference.limits import Properties, printable
from skyverse.model.altitude import FOOT, AboveGround

LEVEL = 3.0
"""Metres that a level counts for, and a roof of which nothing else is said."""
HEIGHT = ("height", "buildingheight", "measuredheight", "renderheight", "estheight")
LOW = ("minheight", "buildingminheight", "renderminheight")
_METRES = re.compile(r"(\d+(?:\.\d*)?|\.\d+)\s*(m|metres?|meters?|ft|feet|foot|')?", re.IGNORECASE)
_FEET = re.compile(r"(\d+)'\s*(?:(\d+(?:\.\d*)?)(?:\"|''))?")


def metres(value: object) -> float | None:
    """Return a length such as ``10``, ``10.5 m``, ``33 ft``, ``33'`` or ``7'4"`` in metres, or ``None``."""
    if isinstance(value, bool):
        return None
    if isinstance(value, int | float):
        return float(value) if abs(value) < 1e5 else None
    if not isinstance(value, str):
        return None
    feet = _FEET.fullmatch(value.strip())
    if feet:
        return _sane((float(feet[1]) + float(feet[2] or 0) / 12) * FOOT)
    plain = _METRES.fullmatch(value.strip())
    if plain is None:
        return None
    return _sane(float(plain[1]) * (FOOT if (plain[2] or "m").lower()[0] in "f'" else 1.0))


def _sane(number: float) -> float | None:
    return number if number < 1e5 else None


def levels(value: object) -> float | None:
    """Return a number of levels; of several, such as ``2;3``, the greatest."""
    if isinstance(value, str):
        numbers = [metres(part) for part in value.split(";")]
        known = [number for number in numbers if number is not None]
        return max(known) if known and len(known) == len(numbers) and not re.search(r"[a-z']", value) else None
    return metres(value)


def building(tags: Properties, where: str, choices: Choices) -> tuple[AboveGround | None, AboveGround]:
    """Return where a building begins, ``None`` for the ground, and how high it ends.

    Raises
    ------
    InputError
        If nothing usable is said of its height, and `choices` have no height for such.
    """
    high = _height(tags, where, choices)
    low = next((m for _, value in tags.of(*LOW) if (m := metres(value)) is not None), None)
    if low is None:
        steps = levels(tags.get("building:min_level"))
        low = None if steps is None else LEVEL * steps
    if low is not None and low >= high:
        choices.tell(f"{where}: said to begin at {low:g} m and to end at {high:g} m; taken from the ground on")
        low = None
    return (AboveGround(low) if low and low > 0 else None), AboveGround(high)


def _height(tags: Properties, where: str, choices: Choices) -> float:
    own = choices.height_field
    unread = None
    found: set[float] = set()
    for field, value in [*([(own, tags.get(own))] if own and tags.get(own) is not None else []), *tags.of(*HEIGHT)]:
        height = metres(value)
        if height is not None and math.isfinite(height) and height > 0:
            if field == own:
                return height
            found.add(height)
        else:
            unread = unread or f"{field!r}: expected a height in metres, found {printable(repr(value)):.40}"
    if len(found) > 1:
        choices.tally["of which fields say several heights, taken as high as the greatest"] += 1
    if found:
        return max(found)
    number = levels(tags.get("building:levels"))
    if number is not None and number > 0:
        choices.tally["with a height guessed from levels"] += 1
        return LEVEL * number + _roof(tags)
    if choices.building_height is not None:
        if unread:
            choices.tell(f"{where}: {unread}; taken as {choices.building_height:g} m")
        return choices.building_height
    reason = unread or "expected a height or levels, found neither"
    raise InputError(f"{where}: {reason}; --building-height gives one to buildings without")


def _roof(tags: Properties) -> float:
    height = metres(tags.get("roof:height"))
    if height is not None and height >= 0:
        return height
    number = levels(tags.get("roof:levels"))
    if number is not None and number >= 0:
        return LEVEL * number
    return 0.0 if tags.get("roof:shape") == "flat" else LEVEL
