"""What closes the way of a UAV to its target, found by leaving one thing out after another until there is a path."""

import math
from collections.abc import Iterator
from contextlib import suppress
from dataclasses import dataclass

import numpy as np

from skyverse._typing import Floats
from skyverse.errors import InputError, Remedy, Sentence
from skyverse.maps.readers.voxel_grid import KIND_OF_UNKNOWN
from skyverse.mission.tours import REASONS
from skyverse.model.mission import Mission, planned_flights
from skyverse.model.quantities import derived
from skyverse.model.result import Status
from skyverse.model.scenario import Bounds, Scenario
from skyverse.model.shapes import LEAST_CLEARANCE, NO_FLY_ZONE, Terrain
from skyverse.model.short_lines import listed
from skyverse.planners.taut import Taut
from skyverse.problem import Problem
from skyverse.space.world import World

MAX_WAYS = 3
"""UAVs without a way of which it is found out at most, as each takes some searches."""
MAX_NAMED = 4
"""Obstacles named at most; of more it is told how many there are."""
HEADROOM = 500.0
"""Metres by which the bounds are made higher to see whether there is a way over what is in it."""
ASIDE = 1.0
"""By how many times their longer side the bounds are widened on each side to see whether there is a way round."""
UNREACHED = (Status.NO_PATH, Status.NO_PATH_EXISTS, Status.START_SHUT_IN)


@dataclass(frozen=True)
class ClosedWay:
    """What closes the way of a UAV to its target.

    Attributes
    ----------
    uav, target
        Their names.
    by
        Each thing without which there is a way, in words; empty where no single one is found.
    give
        Parameters any one of which may open it.
    """

    uav: str
    target: str
    by: tuple[str, ...]
    give: tuple[Remedy, ...]

    @property
    def sentence(self) -> str:
        """All of it, for people."""
        if not self.by:
            return f"{self.uav} has no way to {self.target}, and nothing alone was found that closes it."
        without = ", or ".join(f"without {one}" for one in self.by)
        return Sentence(f"{self.uav} would have a way to {self.target} {without}", give=self.give)


def closed_ways(mission: Mission) -> list[ClosedWay]:
    """Return what closes the ways of the first `MAX_WAYS` UAVs, or to targets of tours, for which no path was found."""
    scenario, lost = mission.scenario, list[tuple[int, int]]()
    for number, flight in enumerate(planned_flights(mission)):
        if flight.result is not None and flight.target is not None and flight.result.status in UNREACHED:
            lost.append((number, scenario.targets.index(flight.target)))
    for target in (one.target for one in mission.unvisited if one.why == REASONS["no way"]):
        wanted = scenario.targets[target].uavs
        lost += [(uav, target) for uav, own in enumerate(scenario.uavs) if not wanted or own.name in wanted][:1]
    return [_closed(scenario, uav, target) for uav, target in lost[:MAX_WAYS]]


def _closed(scenario: Scenario, uav: int, target: int) -> ClosedWay:
    by, give = [], []
    for name, opened, remedies in _without_one(scenario):
        path = _path(opened, uav, target)
        if len(path):
            by.append(name or _crossed(scenario, opened, path))
            give += remedies
    names = scenario.uavs[uav].name, scenario.targets[target].name
    return ClosedWay(*names, tuple(dict.fromkeys(by)), tuple(dict.fromkeys(give)))


def _without_one(scenario: Scenario) -> Iterator[tuple[str, Scenario, list[Remedy]]]:
    """Yield what may close a way, the scenario without it, and what a user may give; obstacles are named later."""
    for solid in (False, True):
        left = tuple(one for one in scenario.obstacles if one.solid is not solid)
        if len(left) < len(scenario.obstacles):
            unknown = solid and any(one.kind == KIND_OF_UNKNOWN["occupied"] for one in scenario.obstacles)
            give = [Remedy("unknown", "free", "to fly through what nobody has seen")] if unknown else []
            yield "", scenario.model_copy(update={"obstacles": left}), give
    if scenario.max_height is not None:
        most = f"the ceiling of {scenario.max_height:g} m above ground"
        yield most, scenario.model_copy(update={"max_height": None}), [Remedy("max_height", None, "that is higher")]
    low, high = np.array(scenario.bounds.min), np.array(scenario.bounds.max)
    higher = Bounds(min=tuple(low), max=(high[0], high[1], high[2] + HEADROOM))
    with suppress(InputError):  # wider bounds may have a lattice of too many nodes
        opened = scenario.model_copy(update={"bounds": higher})
        yield "the top of the bounds", opened, [Remedy("ceiling", None, "when the scenario is built, to fly higher")]
    with suppress(InputError):
        yield "the edge of the area", _wider(scenario), [Remedy("margin", None, "or a larger area, to fly round")]
    if scenario.clearance > LEAST_CLEARANCE:
        kept = {"clearance": LEAST_CLEARANCE, "terrain": _with_clearance(scenario.terrain, scenario.ground_clearance)}
        opened = scenario.model_copy(update=kept)
        yield f"the clearance of {scenario.clearance:g} m", opened, [Remedy("clearance", None, "that is smaller")]
    if scenario.terrain is not None and scenario.ground_clearance > LEAST_CLEARANCE:
        opened = scenario.model_copy(update={"terrain": _with_clearance(scenario.terrain, LEAST_CLEARANCE)})
        above = f"the clearance of {scenario.ground_clearance:g} m from the ground"
        yield above, opened, [Remedy("ground_clearance", None, "that is smaller")]


def _wider(scenario: Scenario) -> Scenario:
    """Return a scenario whose bounds are wider on each side; the ground goes on there as high as at its edge."""
    low, high = np.array(scenario.bounds.min), np.array(scenario.bounds.max)
    more = ASIDE * float((high - low)[:2].max())
    bounds = Bounds(min=(low[0] - more, low[1] - more, low[2]), max=(high[0] + more, high[1] + more, high[2]))
    ground = scenario.terrain
    if ground is not None:
        cells = [math.ceil(more / step) for step in ground.step]
        wide = [(count, count) for count in cells]
        (x, y), (dx, dy) = ground.origin, ground.step
        lowest = None if ground.lowest is None else np.pad(ground.lowest, wide, mode="edge")
        grown = {"heights": np.pad(ground.heights, wide, mode="edge"), "lowest": lowest}
        ground = ground.model_copy(update={**grown, "origin": (x - cells[0] * dx, y - cells[1] * dy)})
    return scenario.model_copy(update={"bounds": bounds, "terrain": ground})


def _with_clearance(ground: Terrain | None, metres: float) -> Terrain | None:
    return None if ground is None else ground.model_copy(update={"clearance": metres})


def _path(scenario: Scenario, uav: int, target: int) -> Floats:
    """Return a path (k, 3) of a UAV to a target, empty where none is found."""
    try:
        found = Taut(proof=0).plan(Problem(scenario, uav, target))
    except InputError:  # such as a lattice of wider bounds that has too many nodes
        return np.empty((0, 3))
    return found.path if found.status.reached else np.empty((0, 3))


def _crossed(scenario: Scenario, opened: Scenario, path: Floats) -> str:
    """Return the obstacles that a path crosses which are not in the scenario that is open, in words."""
    left = {id(one) for one in opened.obstacles}
    names = []
    for number, one in enumerate(scenario.obstacles):
        if id(one) in left:
            continue
        only = {"obstacles": (one,), "zones": (), "movers": (), "terrain": None, "max_height": None}
        if not World(derived(scenario, **only)).segments_free(path[:-1], path[1:]).all():
            kind = one.kind or ("obstacle" if one.solid else NO_FLY_ZONE)
            names.append(f"the {kind} obstacles[{number}]" + (f" ({one.name})" if one.name else ""))
    more = len(names) - MAX_NAMED
    return listed([*names[:MAX_NAMED], *([f"{more} more"] if more > 0 else [])])
