"""Lets the referee judge the flown samples of the runs that came nearest to something.

What is flown is a straight line from sample to sample, which the referee judges at every instant with code of its own.
Obstacles are grown by the vehicle's radius and UAVs keep two radii from each other, so that a touch is a violation.
"""

from typing import NamedTuple

import numpy as np

from skyverse._typing import Floats
from skyverse.flight.run import Fleet, Nearest, Run, fly_run
from skyverse.flight.run_summary import RunSummary
from skyverse.model.flight_runs import Touch
from skyverse.model.mission import Mission
from skyverse.model.scenario import Target
from skyverse.model.trajectory import Trajectory
from skyverse.model.uav import TrackingError
from skyverse.model.verdict import Fault
from skyverse.referee import check

SECONDS_AROUND = 5.0
"""Seconds before and after the nearest instant that are judged."""
CROSS_CHECKED = 3
"""How many of the runs that came nearest to obstacles, to the ground and to other UAVs are judged."""
CONTACTS = (Fault.TRAJECTORY_CLEARANCE, Fault.SEPARATION, Fault.GIVEN)


def cross_check_nearest(fleet: Fleet, done: list[RunSummary]) -> tuple[tuple[str, ...], dict[int, Touch]]:
    """Let the referee judge the runs that came nearest; return what it says, and the touches that it finds."""
    said, found = [], {}
    radius, names = fleet.vehicle.radius, [uav.name for uav in fleet.mission.scenario.uavs]
    for kind, noun, reach in (
        ("obstacle", "an obstacle", radius),
        ("ground", "the ground", radius),
        ("pair", "another UAV", 2 * radius),
    ):
        order = sorted(range(len(done)), key=lambda k: getattr(done[k], kind).distance)[:CROSS_CHECKED]
        near = [k for k in order if getattr(done[k], kind).uavs]
        against = 0
        for k in near:
            nearest: Nearest = getattr(done[k], kind)
            verdict = _cross_check(fleet, fly_run(fleet, done[k].seed), nearest)
            if verdict.touched:
                who = " and ".join(names[uav] for uav in nearest.uavs)
                sentence = f"{who} is within {reach:.3g} m of {noun} at {nearest.time:.2f} s in run {k}, by the referee"
                found[k] = Touch(k, done[k].seed, nearest.time, sentence)
            against += verdict.touched != (nearest.distance <= reach) or bool(verdict.message and not verdict.touched)
        if near:
            least = getattr(done[near[0]], kind).distance
            agrees = "agrees" if not against else f"does not agree in {against} of them"
            said.append(
                f"Nearest to {noun}: {least:.3f} m; the referee's code judged the nearest {len(near)} and {agrees}."
            )
    return tuple(said), found


class _CrossCheck(NamedTuple):
    """What the referee says: whether it finds a touch, and its message where it does or cannot decide."""

    touched: bool
    message: str


def _cross_check(fleet: Fleet, run: Run, nearest: Nearest) -> _CrossCheck:
    """Return what the referee says of the UAVs that came nearest to something, around that instant."""
    scenario, radius = fleet.mission.scenario, fleet.vehicle.radius
    uavs, trajectories = [], []
    for uav in nearest.uavs:
        flown, still = run.samples[uav], fleet.still[uav]
        if flown is not None:
            times, places = flown.times, flown.positions
        else:
            places = np.asarray(still)
            times = np.arange(len(places)) / 100.0
        some = np.abs(times - np.clip(nearest.time, times[0], times[-1])) <= SECONDS_AROUND
        times, places = times[some], places[some]
        vehicle = scenario.uavs[uav]
        changes = {
            "start": tuple(places[0].tolist()),
            "separation": 2 * radius,
            "vertical_separation": 2 * radius,
            "tracking_error": TrackingError(),
        }
        uavs.append(vehicle.model_copy(update=changes))
        trajectories.append(_polyline(times, places) if len(times) > 1 else None)
    changes = {
        "uavs": tuple(uavs),
        "targets": (Target(position=scenario.uavs[0].start),),
        "clearance": radius,
        "max_height": None,
        "terrain": scenario.terrain and scenario.terrain.model_copy(update={"clearance": radius}),
    }
    judged = scenario.model_copy(update=changes)
    nothing = (None,) * len(uavs)
    flown_mission = Mission(judged, nothing, nothing, tuple(trajectories), (), fleet.mission.provenance)
    violations = check(judged, flown_mission)
    touches = [violation.message for violation in violations if violation.fault in CONTACTS]
    undecided = [violation.message for violation in violations if violation.fault is Fault.UNDECIDED]
    return _CrossCheck(bool(touches), next(iter(touches + undecided), ""))


def _polyline(times: Floats, places: Floats) -> Trajectory:
    """Return the straight flights from sample to sample as one trajectory."""
    slopes = np.diff(places, axis=0) / np.diff(times)[:, None]
    return Trajectory(times, np.stack([places[:-1], slopes], axis=1))
