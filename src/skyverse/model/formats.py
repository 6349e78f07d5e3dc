"""The versions of file formats: the data of an older file become those of the newest version, or are refused.

A field that a version brought is refused in a file of an older version, which could not mean it.
"""

from collections.abc import Iterator
from typing import Any, Final

SCENARIO_1: Final = "skyverse/scenario/1"
SCENARIO_2: Final = "skyverse/scenario/2"
MISSION_1: Final = "skyverse/mission/1"
MISSION_2: Final = "skyverse/mission/2"

JUDGEMENTS = ("certificates", "apart")
"""Fields of a mission that no file holds, since only the referee can say what is proven.

Files of version 1 have them; they are not read, as whoever wrote the file may have made them up.
"""
NEW_IN_SCENARIO_2 = {
    "": ("max_height", "movers", "built_with"),
    "uavs": (
        "tracking_error",
        "max_climb",
        "max_descent",
        "hover_power",
        "vehicle",
        "max_yaw_rate",
        "max_yaw_acceleration",
        "look_at",
    ),
    "obstacles": ("solid", "closed_above", "max_speed", "active"),
    "zones": ("solid", "closed_above", "max_speed", "active"),
    "terrain": ("lowest",),
    "sources": ("cautions",),
}
"""The fields that version 2 brought, by the part that has them, or whose entries do; the scenario itself is ``""``."""


def scenario_to_2(data: Any) -> Any:
    """Return the data of a scenario of version 1 as those of version 2, and other data as they are.

    The fields that version 2 brought are left out, which means that there are no such limits.

    Raises
    ------
    ValueError
        If a scenario of version 1 has a field that only version 2 has.
    """
    if not isinstance(data, dict) or data.get("format") != SCENARIO_1:
        return data
    for place in _fields_of_scenario_2(data):
        raise ValueError(f"{place}: {SCENARIO_1!r} has no such field; {SCENARIO_2!r}, as the format, has it")
    return {**data, "format": SCENARIO_2}


def _fields_of_scenario_2(data: dict[Any, Any]) -> Iterator[str]:
    """Yield the places of fields that only version 2 has."""
    for part, names in NEW_IN_SCENARIO_2.items():
        given = data.get(part) if part else data
        for number, entry in enumerate(given if isinstance(given, list | tuple) else [given]):
            if isinstance(entry, dict):
                place = f"{part}." if part and entry is given else f"{part}[{number}]." if part else ""
                yield from (f"{place}{name}" for name in names if name in entry)


def mission_to_2(data: Any) -> Any:
    """Return the data of a mission of version 1 as those of version 2, without what the referee is said to have proven.

    Other data are returned as they are.

    Raises
    ------
    ValueError
        If a mission of version 1 has a field that only version 2 has.
    """
    if not isinstance(data, dict):
        return data
    data = {key: value for key, value in data.items() if key not in JUDGEMENTS}
    if data.get("format") != MISSION_1:
        return data
    for name in ("flights", "source"):
        if name in data:
            raise ValueError(f"{name}: {MISSION_1!r} has no such field; {MISSION_2!r}, as the format, has it")
    results = data.get("results")
    for number, result in enumerate(results if isinstance(results, list | tuple) else ()):
        for name in ("straight_bound", "objective"):
            if isinstance(result, dict) and name in result:
                place = f"results[{number}].{name}"
                raise ValueError(f"{place}: {MISSION_1!r} has no such field; {MISSION_2!r}, as the format, has it")
    return {**data, "format": MISSION_2}


def flight_with_mission_2(data: Any) -> Any:
    """Return the data of a flight with the mission that was flown as one of version 2; see `mission_to_2`."""
    if not isinstance(data, dict) or "mission" not in data:
        return data
    return {**data, "mission": mission_to_2(data["mission"])}


def replanned_flight_with_mission_2(data: Any) -> Any:
    """Return the data of a replanned flight with missions, as planned and as commanded, of version 2."""
    data = flight_with_mission_2(data)
    if not isinstance(data, dict) or "flight" not in data:
        return data
    return {**data, "flight": flight_with_mission_2(data["flight"])}
