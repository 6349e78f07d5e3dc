"""Altitudes that say what they are counted from: mean sea level, home, or the ground below."""

import re
from dataclasses import dataclass

from skyverse.errors import InputError, require_kind, require_number

FOOT = 0.3048
"""Metres."""
MAX_BELOW, MAX_ABOVE = 11_000, 50_000
"""Metres by which an altitude may be below or above what it is counted from: deeper than any sea, above any UAV."""


@dataclass(frozen=True)
class _Metres:
    metres: float

    def __post_init__(self) -> None:
        require_number(self.metres, "metres", "metres")

    def __str__(self) -> str:
        """Return it as `parse_altitude` reads it."""
        return f"{self.metres:.12g} m {next(word for word, kind in REFERENCES.items() if kind is type(self))}"


class AboveSea(_Metres):
    """Metres above mean sea level."""


class AboveHome(_Metres):
    """Metres above the place where the UAV takes off."""


class AboveGround(_Metres):
    """Metres above the ground below."""


Altitude = AboveSea | AboveHome | AboveGround
GlobalPlace = tuple[float, float, Altitude]
"""Latitude, longitude, degrees; altitude."""

REFERENCES: dict[str, type[Altitude]] = {"amsl": AboveSea, "home": AboveHome, "agl": AboveGround}
"""What altitudes are counted from, as it is written."""
MAX_WRITTEN = 60
"""Characters at most of a text that is read as an altitude; matching a pattern to endless blanks would take hours."""
_WRITTEN = re.compile(
    r"\s*([-+]?(?:\d+(?:\.\d*)?|\.\d+)(?:e[-+]?\d+)?)\s*(m|ft)?\s*(amsl|msl|home|agl)?\s*", re.IGNORECASE
)


def parse_altitude(text: str, unit: float | None = None) -> Altitude:
    """Read an altitude such as ``60 m agl``, ``1250m amsl``, ``30 m home`` or ``400 ft agl``.

    Parameters
    ----------
    text
        What is written.
    unit
        Metres in the unit of a number that is written without one; ``None`` where every number must have one.

    Raises
    ------
    InputError
        If the text is no altitude, or does not say its unit or what the altitude is counted from.
    """
    require_kind(text, str, "text")
    found = _WRITTEN.fullmatch(text) if len(text) <= MAX_WRITTEN else None
    if found is None:
        raise InputError(f"expected an altitude such as '60 m agl', found {text!r:.40}")
    number, written_unit, frame = found.groups()
    if frame is None:
        raise InputError(
            f"expected an altitude with what it is counted from, amsl (mean sea level), agl (the ground) or home, "
            f"found {text.strip()!r:.40}"
        )
    if written_unit is not None:
        unit = FOOT if written_unit.lower() == "ft" else 1.0
    if unit is None:
        raise InputError(f"expected an altitude in m or ft, as in '{number} m {frame}', found {text.strip()!r:.40}")
    metres = float(number) * unit
    if not -MAX_BELOW <= metres <= MAX_ABOVE:
        raise InputError(f"expected an altitude from -{MAX_BELOW:,} to {MAX_ABOVE:,} m, found {text.strip()!r:.40}")
    return (REFERENCES | {"msl": AboveSea})[frame.lower()](metres)
