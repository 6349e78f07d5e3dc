"""Holds the least distances of the runs that came nearest against the referee's code.

What was flown is a straight line from sample to sample, which the referee judges at every instant around the nearest
one: grown by a little more than the measured distance, the obstacle must be hit, and grown by less it must not. The
referee grows a box on each axis, which reaches sqrt(3) times as far at a corner as the distance that is measured.
"""

import math
from collections.abc import Sequence

import numpy as np

from skyverse._typing import Floats
from skyverse.flight.commands import COMMAND_RATE
from skyverse.flight.run import Fleet, Nearest, Run, fly_run
from skyverse.flight.run_summary import RunSummary
from skyverse.model.mission import Mission
from skyverse.model.scenario import Objective
from skyverse.model.trajectory import Trajectory
from skyverse.model.uav import TrackingError
from skyverse.model.verdict import Fault
from skyverse.referee import check

CROSS_CHECKED = 3
"""How many of the runs that came nearest to obstacles, to the ground and to other UAVs are held against the referee."""
SECONDS_AROUND = 2.0
"""Seconds before and after the nearest instant that are judged."""
MORE = 0.001
"""Metres added to a measured distance, at which the referee must find something."""


def cross_check_nearest(fleet: Fleet, done: Sequence[RunSummary]) -> tuple[str, ...]:
    """Return one sentence each about the runs that came nearest to obstacles, to the ground, and to other UAVs."""
    said = []
    for kind, noun in (("obstacle", "an obstacle"), ("ground", "the ground"), ("pair", "another UAV")):
        near = [getattr(run, kind) for run in done]
        order = [k for k in np.argsort([nearest.distance for nearest in near])[:CROSS_CHECKED] if near[k].uavs]
        against = sum(not _agrees(fleet, fly_run(fleet, done[k].seed), kind, near[k]) for k in order)
        if order:
            judged = f"the referee's code agrees in the nearest {len(order)}"
            if against:
                judged = f"the referee's code does not agree in {against} of the nearest {len(order)}"
            said.append(f"Nearest to {noun}: {near[order[0]].distance:.3f} m; {judged}.")
    return tuple(said)


def _agrees(fleet: Fleet, run: Run, kind: str, nearest: Nearest) -> bool:
    """Tell whether the referee finds what was nearest at its distance, and nothing at a smaller one."""
    times, places = _around(fleet, run, nearest)
    if not _hit(fleet, kind, nearest, times, places, max(nearest.distance, 0.0) + MORE):
        return False
    steps = sum(float(np.linalg.norm(np.diff(rows, axis=0), axis=1).max(initial=0.0)) for rows in places)
    less = (nearest.distance - steps) / (math.sqrt(3.0) if kind == "obstacle" else 1.0) - MORE
    return less <= 0 or not _hit(fleet, kind, nearest, times, places, less)


def _around(fleet: Fleet, run: Run, nearest: Nearest) -> tuple[Floats, list[Floats]]:
    """Return the samples around the nearest instant, (m,) seconds, and where each of its UAVs is then, (m, 3)."""
    first, last = nearest.time - SECONDS_AROUND, nearest.time + SECONDS_AROUND
    times = np.arange(np.floor(first * COMMAND_RATE), np.ceil(last * COMMAND_RATE) + 1) / COMMAND_RATE
    places = []
    for uav in nearest.uavs:
        flown, still = run.samples[uav], fleet.still[uav]
        known = np.asarray(still) if flown is None else flown.positions
        begin = 0 if flown is None else round(float(flown.times[0]) * COMMAND_RATE)
        rows = np.round(times * COMMAND_RATE).astype(int) - begin
        places.append(known[np.clip(rows, 0, len(known) - 1)])
    return times, places


def _hit(fleet: Fleet, kind: str, nearest: Nearest, times: Floats, places: list[Floats], reach: float) -> bool:
    """Tell whether the referee finds a UAV within `reach` metres of an obstacle, the ground, or another UAV.

    It is asked about nothing else: a pair may be nearer to an obstacle than to each other.
    """
    scenario = fleet.mission.scenario
    uavs, trajectories = [], []
    for uav, rows in zip(nearest.uavs, places, strict=True):
        changes: dict[str, object] = {
            "start": tuple(rows[0].tolist()),
            "home": None,
            "separation": reach,
            "vertical_separation": reach,
            "tracking_error": TrackingError(),
        }
        uavs.append(scenario.uavs[uav].model_copy(update=changes))
        slopes = np.diff(rows, axis=0) / np.diff(times)[:, None]
        trajectories.append(Trajectory(times - times[0], np.stack([rows[:-1], slopes], axis=1)))
    ground = scenario.terrain and scenario.terrain.model_copy(update={"clearance": reach})
    changes = {
        "uavs": tuple(uavs),
        "targets": (),
        "objective": Objective(),
        "clearance": reach,
        "obstacles": scenario.obstacles if kind == "obstacle" else (),
        "terrain": ground if kind == "ground" else None,
        "max_height": None,
    }
    judged, nothing = scenario.model_copy(update=changes), (None,) * len(uavs)
    flown = Mission(judged, nothing, nothing, tuple(trajectories), (), fleet.mission.provenance)
    contacts = (Fault.SEPARATION, Fault.GIVEN) if kind == "pair" else (Fault.TRAJECTORY_CLEARANCE,)
    return any(violation.fault in contacts for violation in check(judged, flown))
