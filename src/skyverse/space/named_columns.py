"""Which UAVs have columns over their starts and targets, in words."""

from collections.abc import Sequence
from typing import NamedTuple

from skyverse.model.scenario import Scenario
from skyverse.model.short_lines import counted
from skyverse.model.uav import TrackingError
from skyverse.space.column import column_top
from skyverse.space.tube import NO_ERROR
from skyverse.space.world import World

MAX_NAMED = 3
"""UAVs whose columns are named; of more it is told how many there are."""


class NamedColumn(NamedTuple):
    """The column over a start or target.

    Attributes
    ----------
    uav
        The index of its UAV.
    end
        ``"start"`` or ``"target"``.
    foot
        Where the start or target is, (3,) metres.
    top
        z at which the column ends, metres.
    """

    uav: int
    end: str
    foot: tuple[float, float, float]
    top: float


def fleet_columns(scenario: Scenario, assignment: Sequence[int | None]) -> list[NamedColumn]:
    """Return the columns over the starts and targets of a fleet.

    Parameters
    ----------
    scenario
        The scenario.
    assignment
        The target of each UAV, ``None`` where it has none.
    """
    if all(uav.tracking_error == NO_ERROR or uav.fixed_wing is not None for uav in scenario.uavs):
        return []
    worlds: dict[TrackingError, World] = {}
    nominal = World(scenario)
    found = []
    for number, (uav, target) in enumerate(zip(scenario.uavs, assignment, strict=True)):
        error = uav.tracking_error
        if error == NO_ERROR or uav.fixed_wing is not None:
            continue
        if error not in worlds:
            worlds[error] = World(scenario, error)
        places = [("start", uav.start)]
        places += [] if target is None else [("target", scenario.targets[target].position)]
        tops = [(end, place, float(column_top(nominal, worlds[error], place)[2])) for end, place in places]
        found += [NamedColumn(number, end, place, top) for end, place, top in tops if top > place[2]]
    return found


def columns_sentence(scenario: Scenario, columns: Sequence[NamedColumn]) -> str:
    """Return a sentence that names the columns of a fleet; empty where there are none."""
    told = []
    for number in dict.fromkeys(column.uav for column in columns):
        own = [f"over its {one.end} up to z = {one.top:.4g} m" for one in columns if one.uav == number]
        told.append(f"{scenario.uavs[number].name} {' and '.join(own)}")
    if not told:
        return ""
    rest = len(told) - MAX_NAMED
    more = f"; and of {counted(rest, 'more UAV')}" if rest > 0 else ""
    return (
        "In the columns over starts and targets the tracking error does not count for the ground and roofs below: "
        f"of {'; of '.join(told[:MAX_NAMED])}{more}."
    )


def named_columns(scenario: Scenario, assignment: Sequence[int | None]) -> str:
    """Return a sentence that names the columns over the starts and targets of a fleet; empty where there are none."""
    return columns_sentence(scenario, fleet_columns(scenario, assignment))
