"""Plans the paths of a fleet so that they are apart in space: UAVs then keep their separation whatever the timing.

One UAV after another, those of higher priority first, keeps its trajectory if it is clear of the paths before it and of
the places of all others, or else is led around them, over them or under them. For its planner they are obstacles:
prisms about the chords of each trajectory, and columns about starts and targets. They hold the separation and the other
UAV's tracking error; the UAV's own error is kept from them as from all obstacles.
"""

from collections.abc import Sequence
from dataclasses import replace
from itertools import pairwise

import numpy as np

from skyverse._typing import Floats
from skyverse.deconfliction.detours import MakeTrajectory, plan_among
from skyverse.interrupt import interrupted
from skyverse.model.mission import Mission
from skyverse.model.pad import home_height
from skyverse.model.quantities import derived
from skyverse.model.scenario import Bounds, Scenario
from skyverse.model.shapes import Prism
from skyverse.model.trajectory import Trajectory
from skyverse.model.uav import kept_ellipsoid
from skyverse.model.verdict import Action, Verdict
from skyverse.numerics.norm import off_chord
from skyverse.numerics.tolerances import MIN_NORM
from skyverse.problem import Airspace, Problem
from skyverse.space.world import World
from skyverse.trajectory.proof import prove

PATH_MARGIN = 0.6
"""Metres added to the separation: exported waypoints and cut corners are off the trajectories by less."""
TAKEOFF_HEIGHT = 3.0
"""Metres above home to which exported missions first climb."""
SAMPLES_PER_PIECE = 16
"""Samples on each piece of a trajectory, from which its chords are made."""
MAX_CLIMB_SHARE = 0.5
"""The largest climb along one chord, as a share of the vertical separation: a prism is as tall as its chord climbs."""


def keep_paths_apart(
    airspace: Airspace, mission: Mission, make_trajectory: MakeTrajectory
) -> tuple[Mission, list[Action]]:
    """Lead UAVs around the paths of others, so that all paths are apart in space as far as they can be.

    The mission with these paths is returned, and what was changed.

    Parameters
    ----------
    airspace
        The airspace of the scenario.
    mission
        As it was planned.
    make_trajectory
        Turns a problem's result into a trajectory.
    """
    scenario = mission.scenario
    results, flown = list(mission.results), list(mission.trajectories)
    actions = []
    placed: list[int] = []
    for uav in sorted(range(len(flown)), key=lambda k: (-scenario.uavs[k].priority, k)):
        own, result, target = flown[uav], results[uav], mission.assignment[uav]
        if own is None or result is None or target is None:
            continue
        walls = [wall for other in range(len(flown)) for wall in _columns_of(mission, uav, other)]
        walls += [wall for other in placed for wall in _around(scenario, uav, other, flown[other])]
        if not interrupted() and not _clear(scenario, uav, own, walls):
            found = plan_among(
                Problem(airspace, uav, target), scenario, walls, make_trajectory, any_angle=result.any_angle
            )
            if found is not None:
                results[uav], flown[uav] = found
                actions.append(Action(uav, "detour", f"{scenario.uavs[uav].name} flies around the paths of others."))
        placed.append(uav)
    return replace(mission, results=tuple(results), trajectories=tuple(flown)), actions


def apart_by_timing_only(mission: Mission) -> list[tuple[int, int]]:
    """Return the pairs of UAVs, (m, 2) indices, whose paths are not proven to be apart in space."""
    scenario, flown = mission.scenario, mission.trajectories
    pairs = []
    for uav, own in enumerate(flown):
        if own is None:
            continue
        walls = [
            _columns_of(mission, uav, other) + (_around(scenario, uav, other, flown[other]) if other < uav else [])
            for other in range(len(flown))
        ]
        if not _clear(scenario, uav, own, [wall for those in walls for wall in those]):
            pairs += [(uav, other) for other, those in enumerate(walls) if not _clear(scenario, uav, own, those)]
    return sorted({(min(pair), max(pair)) for pair in pairs})


def _clear(scenario: Scenario, uav: int, flight: Trajectory, walls: Sequence[Prism]) -> bool:
    """Tell whether it is proven that a flight, which is clear of all obstacles, keeps out of these walls as well."""
    if not walls:
        return True
    vehicle = scenario.uavs[uav]
    error = np.array([vehicle.tracking_error.horizontal] * 2 + [vehicle.tracking_error.vertical])
    low, high = np.array(scenario.bounds.min) - error, np.array(scenario.bounds.max) + error
    bounds = Bounds(min=tuple(low.tolist()), max=tuple(high.tolist()))  # as wide as the columns at the ends need
    alone = {"obstacles": tuple(walls), "terrain": None, "max_height": None, "bounds": bounds}
    world = World(derived(scenario, **alone), vehicle.tracking_error)
    return prove(world, vehicle, flight).verdict is Verdict.PROVEN


def _columns_of(mission: Mission, uav: int, other: int) -> list[Prism]:
    """Return what a UAV must keep clear of about another's start, from the ground on, and its target."""
    if other == uav:
        return []
    scenario, target = mission.scenario, mission.assignment[other]
    start = np.array(scenario.uavs[other].start)
    below = start.copy()
    below[2] = home_height(scenario, other)
    columns = [_prism(scenario, uav, other, below, start, 0.0)]
    if target is not None:
        place = np.array(scenario.targets[target].position)
        columns.append(_prism(scenario, uav, other, place, place, 0.0))
    return columns


def _lift(scenario: Scenario, uav: int) -> float:
    """Return how many metres above its trajectory a UAV may fly its first leg, because it first climbs higher."""
    return max(TAKEOFF_HEIGHT - (scenario.uavs[uav].start[2] - home_height(scenario, uav)), 0.0)


def _around(scenario: Scenario, uav: int, other: int, flight: Trajectory | None) -> list[Prism]:
    """Return prisms about another UAV's flight that a UAV must not enter."""
    if flight is None:
        return []
    curve = flight.at(flight.instants(SAMPLES_PER_PIECE)).position
    tall = max(scenario.uavs[uav].ellipsoid[1], scenario.uavs[other].ellipsoid[1])
    ends = _chord_ends(curve, 0, len(curve) - 1, MAX_CLIMB_SHARE * max(tall, PATH_MARGIN))
    return [
        _prism(scenario, uav, other, curve[a], curve[b], float(off_chord(curve[a : b + 1]).max()))
        for a, b in pairwise(ends)
    ]


def _chord_ends(curve: Floats, first: int, last: int, climb: float) -> list[int]:
    """Return samples between which a curve keeps near its chord and climbs little (Ramer, Douglas and Peucker)."""
    part = curve[first : last + 1]
    off = off_chord(part)
    bent, steep = off.max() > PATH_MARGIN / 4, np.ptp(part[:, 2]) > climb
    if last - first < 2 or not (bent or steep):
        return [first, last]
    middle = first + (int(np.argmax(off)) if bent else (last - first) // 2)
    middle = min(max(middle, first + 1), last - 1)
    return [*_chord_ends(curve, first, middle, climb), *_chord_ends(curve, middle, last, climb)[1:]]


def _prism(scenario: Scenario, uav: int, other: int, a: Floats, b: Floats, off: float) -> Prism:
    """Return a prism: grown by the clearance and the UAV's own error, it holds all that is too close to a chord."""
    own = scenario.uavs[uav].tracking_error
    beside, above = kept_ellipsoid(scenario.uavs[uav], scenario.uavs[other])
    beside, above = beside - own.horizontal, above - own.vertical
    wide = max(beside + PATH_MARGIN + off - scenario.clearance, PATH_MARGIN / 4)
    tall = max(above + PATH_MARGIN + off - scenario.clearance, PATH_MARGIN / 4)
    way = (b - a)[:2]
    length = float(np.hypot(*way))
    ahead = way / length if length > MIN_NORM else np.array([1.0, 0.0])
    aside = np.array([-ahead[1], ahead[0]])
    signs = ((-1, -1), (1, -1), (1, 1), (-1, 1))
    corners = [(b if along > 0 else a)[:2] + wide * (along * ahead + across * aside) for along, across in signs]
    return Prism(
        vertices=tuple(tuple(corner.tolist()) for corner in corners),
        low=float(min(a[2], b[2])) - tall - _lift(scenario, uav),
        high=float(max(a[2], b[2])) + tall + _lift(scenario, other),
        kind="path of another UAV",
    )
