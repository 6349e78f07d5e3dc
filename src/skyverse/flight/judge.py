"""Judges a flight: tracking errors, violations, and how near UAVs came to obstacles, movers and each other."""

import itertools
from collections.abc import Sequence

import numpy as np

from skyverse._typing import Floats
from skyverse.flight.commands import COMMAND_RATE
from skyverse.flight.simulator import Samples
from skyverse.flight.tracking_control import LOST_DISTANCE
from skyverse.flight.vehicle import Vehicle
from skyverse.model.flight_record import NEAR_ENOUGH, Flown, FlownVisit, Nearest
from skyverse.model.mission import Mission
from skyverse.model.mover import Doubt
from skyverse.model.scenario import Scenario
from skyverse.model.shapes import Terrain
from skyverse.model.short_lines import told_instant
from skyverse.model.timed_shapes import TimedShape
from skyverse.model.uav import TrackingError
from skyverse.model.verdict import Fault, Violation
from skyverse.numerics.tolerances import NEARNESS_ROUNDING
from skyverse.space.timed_shapes import mover_gaps, moving_shapes
from skyverse.space.world import World


def measure(world: World, mission: Mission, uav: int, samples: Samples, vehicle: Vehicle) -> Flown:
    """Return the record of one UAV's flight; `world` contains the obstacles, but not the terrain."""
    trajectory = mission.trajectories[uav]
    assert trajectory is not None
    commanded = trajectory.at(samples.times).position
    errors = np.linalg.norm(samples.positions - commanded, axis=1)
    distances = world.distance(samples.positions)
    nearest = int(np.argmin(distances))
    terrain = mission.scenario.terrain
    low, high = mission.scenario.bounds.min, mission.scenario.bounds.max
    thrust = vehicle.parameters["k_eta"] * np.sum(samples.rotors**2, axis=1) / vehicle.max_thrust
    power = vehicle.parameters["k_m"] * np.sum(samples.rotors**3, axis=1)
    return Flown(
        uav=uav,
        times=samples.times,
        positions=samples.positions,
        velocities=samples.velocities,
        commanded=commanded,
        rms=float(np.sqrt(np.mean(errors**2))),
        largest=float(errors.max()),
        clearance=float(distances[nearest]),
        clearance_time=float(samples.times[nearest]),
        outside=float(max(0.0, np.max(low - samples.positions), np.max(samples.positions - high))),
        peak_thrust=float(thrust.max()),
        mean_thrust=float(thrust.mean()),
        peak_tilt=float(samples.tilt.max()),
        energy=float(np.trapezoid(power, samples.times)),
        above_ground=None if terrain is None else float(_heights(terrain, samples.positions).min()),
    )


def passings(mission: Mission, flown: tuple[Flown | None, ...], margin: float) -> tuple[list[Nearest], list[Violation]]:
    """Return the closest passing of every pair of UAVs, and the violations of pairs that came too close.

    A UAV that was not flown follows its trajectory exactly, or stays at its start. Where starts (or targets) are given
    closer than the separation, a pair must keep the given nearness until it is first planned to be apart (or from when
    it is last planned to be), less the share of it that the margin is of the separation.
    """
    uavs = mission.scenario.uavs
    ends = [f.times[-1] for f in flown if f is not None] + [mission.makespan]
    times = np.arange(np.ceil(max(ends) * COMMAND_RATE) + 1) / COMMAND_RATE
    planned = [planned_places(mission, uav, times) for uav in range(len(uavs))]
    actual = [p if f is None else _held(f, times) for p, f in zip(planned, flown, strict=True)]
    found, wrong = [], []
    for i, j in itertools.combinations(range(len(uavs)), 2):
        level, upright = separation_of(mission, i, j)
        if level == 0:
            continue
        meant = _nearness(planned[i] - planned[j], level, upright)
        apart = actual[i] - actual[j]
        nearness = _nearness(apart, level, upright)
        k = int(np.argmin(nearness))
        pair = (i, j)
        found.append(
            Nearest(
                pair,
                float(times[k]),
                float(np.linalg.norm(apart[k])),
                nearness=float(nearness[k]),
                planned=float(meant.min()),
            )
        )
        strayed = _nearness(apart, max(level - 2 * margin, 1e-9), max(upright - 2 * margin, 1e-9))
        asked = _asked(mission, i, j, meant)
        k = int(np.argmin(strayed - asked))
        if strayed[k] < asked[k]:
            middle = (actual[i][k] + actual[j][k]) / 2
            eased = asked[k] < 1.0 - NEARNESS_ROUNDING
            given = f", {asked[k]:.2f} as their starts or targets are given" if eased else ""
            message = (
                f"{uavs[i].name} and {uavs[j].name} come within {np.linalg.norm(apart[k]):.3f} m of each other at "
                f"{times[k]:.2f} s, {nearness[k]:.2f} of their separation{given}; {margin:.3g} m each may be strayed"
            )
            wrong.append(Violation(Fault.SEPARATION, pair, message, float(times[k]), _place(middle)))
    return found, wrong


def planned_close(mission: Mission, i: int, j: int) -> bool:
    """Return whether the planned trajectories of two UAVs already come closer than required."""
    times = np.arange(np.ceil(mission.makespan * COMMAND_RATE) + 1) / COMMAND_RATE
    apart = planned_places(mission, i, times) - planned_places(mission, j, times)
    meant = _nearness(apart, *separation_of(mission, i, j))
    return bool(np.any(meant < _asked(mission, i, j, meant) - 10 * NEARNESS_ROUNDING))


def separation_of(mission: Mission, i: int, j: int) -> tuple[float, float]:
    """Return the horizontal and the vertical semi-axis, metres, that count between two UAVs."""
    level, upright = np.maximum(mission.scenario.uavs[i].ellipsoid, mission.scenario.uavs[j].ellipsoid)
    return float(level), float(upright)


def planned_places(mission: Mission, uav: int, times: Floats) -> Floats:
    """Return where a UAV is to be at instants (m,), (m, 3) metres; one without a trajectory stays at its start."""
    """Return where a UAV is to be at instants (m,), (m, 3) metres; one without a trajectory stays at its start."""
    trajectory = mission.trajectories[uav]
    if trajectory is None:
        return np.broadcast_to(np.array(mission.scenario.uavs[uav].start, dtype=np.float64), (len(times), 3))
    return trajectory.at(times).position


def _held(flown: Flown, times: Floats) -> Floats:
    return np.column_stack([np.interp(times, flown.times, flown.positions[:, axis]) for axis in range(3)])


def _nearness(apart: Floats, level: float, upright: float) -> Floats:
    return np.linalg.norm(apart / [level, level, upright], axis=1)


def _asked(mission: Mission, i: int, j: int, meant: Floats) -> Floats:
    """Return the required nearness, (m,): below 1 only while the given starts or targets are too close."""
    uavs = mission.scenario.uavs
    asked = np.full(len(meant), 1.0 - NEARNESS_ROUNDING)
    clear = np.flatnonzero(meant >= 1.0 - NEARNESS_ROUNDING)
    first, last = (clear[0], clear[-1] + 1) if len(clear) else (len(meant), 0)

    def given(one: tuple[float, ...], other: tuple[float, ...]) -> float:
        return float(_nearness(np.subtract([one], [other]), *separation_of(mission, i, j))[0]) - NEARNESS_ROUNDING

    asked[:first] = np.minimum(asked[:first], given(uavs[i].start, uavs[j].start))
    if mission.trajectories[i] is not None and mission.trajectories[j] is not None:
        one, other = (mission.scenario.end_place(uav, mission.assignment[uav]) for uav in (i, j))
        if one is not None and other is not None:
            asked[last:] = np.minimum(asked[last:], given(one, other))
    return asked


def strayed(scenario: Scenario, flown: Flown, margin: float, due: float, speeds: str) -> list[Violation]:
    """Return the violations of one UAV: too near to obstacles or ground, out of bounds, off its target, or lost.

    `due` is the instant before which it is lost if it is flown no more, and `speeds` says if that is too fast for it.
    """
    name, wrong = scenario.uavs[flown.uav].name, []

    def note(fault: Fault, message: str, k: int) -> None:
        place = _place(flown.positions[k])
        wrong.append(Violation(fault, (flown.uav,), f"{name} {message}", float(flown.times[k]), place))

    left = scenario.clearance - margin
    if flown.clearance <= 0 or flown.clearance < left:
        k = int(np.searchsorted(flown.times, flown.clearance_time))
        how = "touches an obstacle" if flown.clearance <= 0 else f"comes within {flown.clearance:.3f} m of an obstacle"
        note(Fault.TRAJECTORY_CLEARANCE, f"{how} {told_instant(flown.clearance_time)}; {left:.3g} m must be left", k)
    if scenario.terrain is not None:
        heights = _heights(scenario.terrain, flown.positions)
        k, least, left = int(np.argmin(heights)), float(heights.min()), scenario.ground_clearance - margin
        if least <= 0 or least < left:
            how = "touches the ground" if least <= 0 else f"is {least:.3f} m above ground"
            note(Fault.TRAJECTORY_CLEARANCE, f"{how} {told_instant(flown.times[k])}; {left:.3g} m must be left", k)
    if flown.outside > margin:
        beyond = np.maximum(scenario.bounds.min - flown.positions, flown.positions - scenario.bounds.max).max(axis=1)
        k = int(np.argmax(beyond))
        out = f"is {beyond[k]:.3f} m out of bounds {told_instant(flown.times[k])}; {margin:.3g} m may be strayed"
        note(Fault.TRAJECTORY_BOUNDS, out, k)
    off = float(np.linalg.norm(flown.positions[-1] - flown.commanded[-1]))
    if flown.times[-1] < due:
        cut = f"more than {LOST_DISTANCE:g} m off its trajectory, where its simulation ends; it is due at {due:.2f} s"
        note(Fault.TRAJECTORY_ENDS, f"is lost {told_instant(flown.times[-1])}: it is {cut}{speeds}", -1)
    elif off > max(margin, NEAR_ENOUGH):
        note(Fault.TRAJECTORY_ENDS, f"is {off:.3f} m off its trajectory when it is flown no more", -1)
    return wrong


def missed(scenario: Scenario, visits: Sequence[FlownVisit]) -> list[Violation]:
    """Return the violations of UAVs that were off targets while they were to stay there, or lost before."""
    wrong = []
    for one in visits:
        if one.kept:
            continue
        uav, target = scenario.uavs[one.uav].name, scenario.targets[one.target]
        how = (
            f"is {one.farthest:.3f} m off {target.name}"
            if np.isfinite(one.farthest)
            else f"is lost before {target.name}"
        )
        message = f"{uav} {how}, where it was to be from {one.arrival:.2f} s to {one.departure:.2f} s"
        wrong.append(Violation(Fault.VISIT, (one.uav,), message, one.arrival, target.position))
    return wrong


def _heights(terrain: Terrain, positions: Floats) -> Floats:
    return positions[:, 2] - terrain.height(positions[:, :2])


def _place(position: Floats) -> tuple[float, float, float]:
    x, y, z = position.tolist()
    return x, y, z


def approaches(truth: Scenario, flown: tuple[Flown | None, ...]) -> tuple[Nearest, ...]:
    """Return each UAV and mover when they were nearest to each other, by the samples of the flight."""
    certain = [TimedShape(mover.shape, mover.motion, Doubt(), 0.0) for mover in truth.movers]
    shapes, found = moving_shapes(certain, TrackingError()), []
    for one in flown:
        if one is None:
            continue
        for number, away in enumerate(mover_gaps(shapes, one.times, one.positions)):
            k = int(np.argmin(away))
            found.append(Nearest((one.uav,), float(one.times[k]), float(away[k]), number))
    return tuple(found)


def too_near(
    truth: Scenario, flown: tuple[Flown | None, ...], near: tuple[Nearest, ...], margin: float
) -> list[Violation]:
    """Return the violations of UAVs that came nearer to movers than the clearance less the margin, or touched them."""
    wrong, left = [], truth.clearance - margin
    for one in near:
        if one.distance > 0 and one.distance >= left:
            continue
        name, whom = truth.uavs[one.uavs[0]].name, f"mover {truth.movers[one.mover or 0].name!r}"
        how = f"touches {whom}" if one.distance <= 0 else f"comes within {one.distance:.3f} m of {whom}"
        message = f"{name} {how} {told_instant(one.time)}; {left:.3g} m must be left"
        record = flown[one.uavs[0]]
        assert record is not None
        x, y, z = record.positions[int(np.searchsorted(record.times, one.time))].tolist()
        wrong.append(Violation(Fault.MOVER, one.uavs, message, one.time, (x, y, z)))
    return wrong
