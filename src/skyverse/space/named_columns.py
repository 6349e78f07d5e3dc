"""Which UAVs have columns over their starts and targets, in words."""

from collections.abc import Sequence

from skyverse.model.scenario import Scenario
from skyverse.model.uav import TrackingError
from skyverse.space.column import column_top
from skyverse.space.tube import NO_ERROR
from skyverse.space.world import World

MAX_NAMED = 3
"""UAVs whose columns are named; of more it is told how many there are."""


def named_columns(scenario: Scenario, assignment: Sequence[int | None]) -> str:
    """Return a sentence that names the columns over starts and targets of a fleet; empty where there are none.

    Parameters
    ----------
    scenario
        The scenario.
    assignment
        The target of each UAV, ``None`` where it has none.
    """
    if all(uav.tracking_error == NO_ERROR or uav.fixed_wing is not None for uav in scenario.uavs):
        return ""
    worlds: dict[TrackingError, World] = {}
    nominal = World(scenario)
    told = []
    for uav, target in zip(scenario.uavs, assignment, strict=True):
        error = uav.tracking_error
        if error == NO_ERROR or uav.fixed_wing is not None:
            continue
        if error not in worlds:
            worlds[error] = World(scenario, error)
        places = [("start", uav.start)]
        places += [] if target is None else [("target", scenario.targets[target].position)]
        tops = [(noun, place[2], column_top(nominal, worlds[error], place)[2]) for noun, place in places]
        named = [f"over its {noun} up to z = {top:.4g} m" for noun, foot, top in tops if top > foot]
        told += [f"{uav.name} {' and '.join(named)}"] if named else []
    if not told:
        return ""
    rest = len(told) - MAX_NAMED
    more = f"; and of {rest} more UAV{'s' * (rest > 1)}" if rest > 0 else ""
    return (
        "In the columns over starts and targets the tracking error does not count for the ground and roofs below: "
        f"of {'; of '.join(told[:MAX_NAMED])}{more}."
    )
