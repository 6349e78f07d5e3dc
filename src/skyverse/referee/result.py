"""Judges one UAV's result: its status and, where it has one, its path."""

from collections.abc import Iterator

import numpy as np

from skyverse._typing import Floats
from skyverse.model.result import Result, Status
from skyverse.model.scenario import Scenario
from skyverse.model.verdict import Fault, Violation
from skyverse.referee.judgement import position_text
from skyverse.referee.path import judge_ends, judge_moves, judge_safety
from skyverse.referee.sorties import Tour
from skyverse.referee.untrusted import float_array
from skyverse.referee.world import RefereeWorld


def judge_result(
    world: RefereeWorld, uav: int, tour: Tour, result: Result, has_trajectory: bool | None
) -> Iterator[Violation]:
    """Yield what is wrong with UAV number `uav`'s result.

    Parameters
    ----------
    world
        What was given.
    uav, tour
        The index of the UAV, and what it visits.
    result
        What is judged.
    has_trajectory
        Whether the mission has a trajectory of the UAV; ``None`` where there is no mission to tell.
    """
    scenario, status = world.scenario, result.status
    name = scenario.uavs[uav].name
    if not isinstance(status, Status):
        yield Violation(Fault.STATUS, (uav,), f"{name}'s status is {status!r}, which is none.")
        return
    expected = has_trajectory in (None, status.reached) or (has_trajectory and not tour.visited)
    if not expected:
        has = "a trajectory" if has_trajectory else "no trajectory"
        why = "" if has_trajectory else _too_slow_for_an_aeroplane(scenario, uav)
        yield Violation(Fault.TRAJECTORY_SHAPE, (uav,), f"{name}'s status is {status.value}, but it has {has}{why}.")

    path = float_array(result.path)
    if not status.reached and status is not Status.INCOMPLETE:
        yield from _judge_absence(world, uav, tour, path, result)
        return
    if path is None or path.ndim != 2 or path.shape[1] != 3 or not len(path) or not np.isfinite(path).all():
        found = "no numbers" if path is None else f"shape {path.shape}, {np.sum(~np.isfinite(path))} not finite"
        message = f"{name}'s path ({status.value}) must be one or more rows of x, y, z, but it has {found}."
        yield Violation(Fault.PATH_SHAPE, (uav,), message)
        return
    yield from judge_safety(world, uav, tour, path)
    if not isinstance(result.any_angle, bool):
        message = f"{name}'s any_angle must be true or false, but is {result.any_angle!r}."
        yield Violation(Fault.PATH_SHAPE, (uav,), message)
        return
    if not result.any_angle and (scenario.objective.unit == "nodes" or status is Status.OPTIMAL):
        yield from judge_moves(world, uav, path)
    yield from judge_ends(world, uav, tour, path, result)


def _judge_absence(
    world: RefereeWorld, uav: int, tour: Tour, path: Floats | None, result: Result
) -> Iterator[Violation]:
    """Yield what is wrong with a result whose status says that there is no path."""
    scenario, status = world.scenario, result.status
    name = scenario.uavs[uav].name
    if path is None or path.size:
        message = f"{name} has a path although its status, {status.value}, says that none was begun."
        yield Violation(Fault.STATUS, (uav,), message)
    claimed = {Status.START_OUT_OF_BOUNDS: scenario.uavs[uav].start}
    if tour.visited:
        claimed[Status.TARGET_OUT_OF_BOUNDS] = scenario.targets[tour.visited[-1]].position
    if status in claimed:
        position = np.array(claimed[status])
        if world.nominal.beyond_bounds(position[None])[0] <= 0:
            message = f"{name}'s status is {status.value}, but {position_text(position)} lies within the bounds."
            yield Violation(Fault.STATUS, (uav,), message)


def _too_slow_for_an_aeroplane(scenario: Scenario, uav: int) -> str:
    """Return words on the zones whose speed limit an aeroplane cannot keep, if there are any."""
    wing = scenario.uavs[uav].fixed_wing
    zones = [k for k, zone in enumerate(scenario.zones) if wing and zone.max_speed and zone.max_speed < wing.speed]
    if wing is None or not zones:
        return ""
    return f"; at its {wing.speed:g} m/s it cannot keep the speed limit of zone {', '.join(map(str, zones))}"
