"""From a result's path to the trajectory that a mission carries, proven at every instant."""

from collections.abc import Iterator, Sequence
from dataclasses import replace
from typing import Literal, get_args

import numpy as np

from skyverse._typing import Floats
from skyverse.cost import soft_terms
from skyverse.errors import require_choice
from skyverse.model.quantities import derived
from skyverse.model.result import Result
from skyverse.model.trajectory import Trajectory, joined
from skyverse.model.uav import UAV
from skyverse.model.verdict import Verdict
from skyverse.numerics.tolerances import MIN_PATH
from skyverse.problem import Problem
from skyverse.search.path_shortening.shortcut import drop_collinear, shortcut
from skyverse.space.speed_zones import first_too_fast
from skyverse.space.world import World
from skyverse.summary import flown_length, largest_distance, turning
from skyverse.trajectory.aeroplane import Headings, fly_aeroplane, fly_straight
from skyverse.trajectory.blended import blended
from skyverse.trajectory.heading import with_heading
from skyverse.trajectory.leg_parts import rest_to_rest
from skyverse.trajectory.proof import prove
from skyverse.trajectory.smooth import CLOSE_REACH, smooth
from skyverse.trajectory.straight_legs import least_seconds

Shape = Literal["minimum-time", "minimum-snap", "minimum-jerk", "stop-and-go"]
SLOWDOWN = 1.1
"""How many times as long a trajectory takes that is tried more slowly."""
TOLERANCE = 2.0
"""Metres that a flight may be from its path without saying so: about as far as satellite navigation is off anyway."""
WORTH_A_SPLINE = 1.02
"""How many times as long a flight must take as its legs would without bends, for a spline to be tried instead."""

UNPROVEN = "The faster trajectory could not be proven safe."
WORTH_TURNS, MORE_TURNING = 1.03, 10.0
"""How many times as long straight legs must take for a spline that turns more, by more than so many degrees."""


def fly_along(problem: Problem, result: Result, shape: Shape = "minimum-time") -> Trajectory | None:
    """Turn a result's path into a trajectory from the UAV's true start to its true target, proven at every instant.

    Nodes on a straight line are dropped, and line-of-sight shortcuts leave out further ones. Where the objective prices
    altitude, risk or climb, which shortcuts would ignore, there are none, and the trajectory keeps close to the path. A
    multirotor flies straight legs with blends at the bends, or a spline through a corridor around the path. Where this
    is not proven, it flies more slowly, or closer to the path, and at last from waypoint to waypoint. An aeroplane
    flies Dubins paths. On the pads at its start and target, which a UAV with a tracking error may have, it flies
    straight up and down and stops at their tops.

    Parameters
    ----------
    problem, result
        The path that was planned, and for what.
    shape
        Of a multirotor's trajectory: straight legs with blends at the bends, or a spline where that is faster and no
        farther from the path than `TOLERANCE`; a spline with little snap, or jerk; or at rest at every waypoint.

    Returns
    -------
    Trajectory or None
        Its `form` says what it is, and its `note` why it is not the shape that was asked for. ``None`` if there is no
        path, or if no trajectory along it can be proven, as for an aeroplane that has no space to turn.

    Raises
    ------
    InputError
        If there is no such shape.
    """
    flown = leg_along(problem, result, shape)
    return None if flown is None else with_heading(flown, problem.scenario.uavs[problem.uav])


def leg_along(
    problem: Problem, result: Result, shape: Shape = "minimum-time", headings: Headings = (None, None)
) -> Trajectory | None:
    """Return the trajectory of `fly_along` before it is said where the UAV's nose points: a leg of a tour.

    The headings are an aeroplane's where it begins and ends.
    """
    require_choice(shape, get_args(Shape), "shape")
    if not result.status.reached:
        return None
    scenario, world = problem.scenario, problem.airspace.world
    uav = scenario.uavs[problem.uav]
    waypoints, priced = needed_waypoints(problem, result), bool(soft_terms(scenario))
    for trajectory in _attempts(world, uav, waypoints, shape, priced, headings):
        if prove(world, uav, trajectory).verdict is Verdict.PROVEN:
            return _with_lifts(problem, trajectory)
    return None


def straight_along(problem: Problem, waypoints: Floats, max_speed: float) -> Trajectory | None:
    """Return the trajectory from rest to rest along waypoints (n, 3), with blends at bends that hardly leave them.

    It is no faster than `max_speed`, m/s; ``None`` where none could be proven. An aeroplane flies through at its speed.
    """
    world, uav = problem.airspace.world, problem.scenario.uavs[problem.uav]
    if uav.fixed_wing is not None:
        flown = fly_straight(world, waypoints, uav) if uav.fixed_wing.speed <= max_speed else None
        return flown if flown is not None and prove(world, uav, flown).verdict is Verdict.PROVEN else None
    slowed = derived(uav, max_speed=min(uav.max_speed, max_speed))
    for stops in (False, True):
        trajectory = (
            rest_to_rest(waypoints, slowed, zones=world.speed_zones, winds=world.scenario.winds)
            if stops
            else blended(world, waypoints, slowed, CLOSE_REACH)
        )
        if prove(world, slowed, trajectory).verdict is Verdict.PROVEN:
            return trajectory
    return None


def stopping_along(problem: Problem, ways: Sequence[Floats], max_speed: float, stay: float) -> Trajectory | None:
    """Return the trajectory along ways (n, 3), each as of `straight_along`, that stands `stay` seconds at every end."""
    flown = [straight_along(problem, way, max_speed) for way in ways]
    parts = [Trajectory(np.array([0.0, stay]), ways[0][None, :1])]
    for way, part in zip(ways, flown, strict=True):
        if part is None:
            return None
        parts += [part, Trajectory(np.array([0.0, stay]), way[None, -1:])]
    return joined(parts)


def needed_waypoints(problem: Problem, result: Result) -> Floats:
    """Return the waypoints of a result's path that a flight needs, from the true start to the true target, (n, 3)."""
    path = problem.without_lifts(result.path) if result.any_angle else result.path
    waypoints = drop_collinear(np.vstack([problem.start, path, problem.end]))
    if not soft_terms(problem.scenario):
        waypoints = shortcut(problem.airspace.world.space, waypoints)
    return waypoints


def _with_lifts(problem: Problem, trajectory: Trajectory) -> Trajectory | None:
    """Return a trajectory with the legs on the pads at start and target, at rest at both ends of each leg.

    There the UAV's nominal position alone keeps the clearance, which is proven here; ``None`` where it is not.
    """
    uav, nominal = problem.scenario.uavs[problem.uav], problem.airspace.nominal.world
    up, down = problem.lifts
    zones = problem.airspace.world.speed_zones  # the tracking error counts for these on pads too
    winds = problem.scenario.winds
    parts = [trajectory]
    if len(up):
        parts.insert(0, rest_to_rest(np.vstack([up, problem.start]), uav, zones=zones, winds=winds))
    if len(down):
        parts.append(rest_to_rest(np.vstack([problem.end, down]), uav, zones=zones, winds=winds))
    if len(parts) == 1:
        return trajectory
    if any(prove(nominal, uav, part).verdict is not Verdict.PROVEN for part in parts if part is not trajectory):
        return None
    return replace(joined(parts), form=trajectory.form, note=trajectory.note)


def _attempts(
    world: World, uav: UAV, waypoints: Floats, shape: Shape, close: bool, headings: Headings
) -> Iterator[Trajectory]:
    """Yield trajectories along waypoints, the best first; `close` keeps a multirotor close to them."""
    if uav.fixed_wing is not None:
        flown = fly_aeroplane(world, waypoints, uav, headings)
        if flown is not None:
            yield flown
        return
    winds = world.scenario.winds
    stops = rest_to_rest(waypoints, uav, zones=world.speed_zones, winds=winds)
    if shape == "stop-and-go" or np.linalg.norm(np.diff(waypoints, axis=0), axis=1).sum() <= MIN_PATH:
        yield stops
        yield _slower(stops, "As fast as its limits allow it could not be proven safe.")
        return
    straight = blended(world, waypoints, uav, CLOSE_REACH if close else TOLERANCE)
    why = ""
    if shape == "minimum-time":
        if straight.end > WORTH_A_SPLINE * least_seconds(waypoints, uav, winds):
            flown = smooth(world, waypoints, uav, 3, close=close)
            if flown is not None and _is_better(flown, straight) and largest_distance(flown, waypoints) <= TOLERANCE:
                yield flown
        if stops.end < straight.end:  # slow zones may reach farther round blends
            yield stops
    else:
        order = 4 if shape == "minimum-snap" else 3
        flown = smooth(world, waypoints, uav, order, close=close)
        why = _why_no_spline(world, flown, straight)
        if flown is not None and not why:
            yield _remarked(flown, waypoints)
            why = UNPROVEN
            yield _remarked(_slower(flown, why), waypoints)
            nearer = smooth(world, waypoints, uav, order, close=True)
            if nearer is not None:
                yield _remarked(replace(nearer, form="straightened", note=why), waypoints)
    yield replace(straight, note=why)
    why = why or UNPROVEN
    yield from (_slower(straight, why), replace(stops, note=why), _slower(stops, why))


def _slower(flown: Trajectory, note: str) -> Trajectory:
    return replace(flown.retimed(flown.start, SLOWDOWN), note=note)


def _why_no_spline(world: World, flown: Trajectory | None, straight: Trajectory) -> str:
    """Say why a spline is not tried, or return an empty sentence."""
    if flown is None:
        return "The passage is too narrow for a spline."
    if flown.end > straight.end * SLOWDOWN:
        return "Straight legs with blends at the bends take less time."
    if first_too_fast(world.speed_zones, flown) is not None:
        return "A spline would exceed the speed limit of a zone."
    return ""


def _is_better(flown: Trajectory, straight: Trajectory) -> bool:
    """Tell whether a spline is faster than straight legs by a larger factor than it is longer, and turns no more.

    One that turns more must be faster by `WORTH_TURNS`.
    """
    if flown.end >= straight.end or flown.end * flown_length(flown) >= straight.end * flown_length(straight):
        return False
    return straight.end >= WORTH_TURNS * flown.end or turning(flown) <= turning(straight) + MORE_TURNING


def _remarked(flown: Trajectory, waypoints: Floats) -> Trajectory:
    """Return a trajectory whose note also says how far it is from its path, where that is more than `TOLERANCE`."""
    off = largest_distance(flown, waypoints)
    if off <= TOLERANCE:
        return flown
    return replace(flown, note=f"{flown.note} It leaves its path by up to {off:.1f} m.".strip())
