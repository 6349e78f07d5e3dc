"""One run of a whole mission in the compiled simulator: errors, distances, and what was touched.

What is kept of one run: least distances, largest errors, how many errors of each size, and what was touched.

Holds the least distances of the runs that came nearest against the referee's code.

What was flown is a straight line from sample to sample, which the referee judges at every instant around the nearest
one: grown by a little more than the measured distance, the obstacle must be hit, and grown by less it must not. The
referee grows a box on each axis, which reaches sqrt(3) times as far at a corner as the distance that is measured.
"""

import itertools
import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from skyverse._typing import Floats, Ints
from skyverse.flight.commands import COMMAND_RATE, Commands, commands_to
from skyverse.flight.judge import planned_places, separation_of
from skyverse.flight.simulator import Samples, simulate
from skyverse.flight.tracking_control import LOST_DISTANCE
from skyverse.flight.vehicle import Vehicle, told_airspeeds
from skyverse.model.conditions import Conditions
from skyverse.model.flight_record import Distribution, Nearest
from skyverse.model.mission import Mission
from skyverse.model.quantities import derived
from skyverse.model.short_lines import told_instant
from skyverse.model.verdict import Fault, Violation
from skyverse.referee.clearance import judge_segments
from skyverse.referee.solids import distance_to_segment
from skyverse.referee.world import referee_world
from skyverse.space.world import World


@dataclass(frozen=True, eq=False)
class Fleet:
    """What all runs of a mission share.

    Attributes
    ----------
    mission, vehicle, conditions
        What is flown, by which vehicle, and what disturbs it.
    commands
        The commands to each UAV; ``None`` for those that are not flown.
    world
        The obstacles and the terrain.
    still
        The (m, 3) planned positions of each UAV that is not flown, `COMMAND_RATE` a second; ``None`` for the others.
    pairs
        The pairs of UAVs that must keep a separation, with its horizontal and vertical semi-axes, metres.
    """

    mission: Mission
    vehicle: Vehicle
    conditions: Conditions
    commands: tuple[Commands | None, ...]
    world: World
    still: tuple[Floats | None, ...]
    pairs: tuple[tuple[int, int, float, float], ...]


class SimulatedRun(NamedTuple):
    """What came of one run.

    Attributes
    ----------
    seed
        Its seed.
    samples
        The motion of each UAV; ``None`` for those that were not flown.
    errors
        (m, 2) horizontal and vertical tracking errors of each UAV, metres; ``None`` for those that were not flown.
    obstacle, ground, pair
        The least distance of any centre to an obstacle as given and to the ground, and of any two centres.
    nearness
        The least distance of any two as a share of their separation.
    outside
        Metres by which the bounds were left at most.
    largest
        (number of UAVs, 2) metres: the largest horizontal and vertical error of each.
    lost
        The instant, seconds, at which the first UAV was lost, and which one that was, if any was.
    """

    seed: int
    samples: tuple[Samples | None, ...]
    errors: tuple[Floats | None, ...]
    obstacle: Nearest
    ground: Nearest
    pair: Nearest
    nearness: float
    outside: float
    largest: Floats
    lost: tuple[float, int] | None


BETWEEN_SAMPLES = 11
"""Places between two samples at which the least distance is looked for."""
NOWHERE = Nearest((), 0.0, np.inf)
"""What stands where there is nothing to come near to."""


def prepare(mission: Mission, vehicle: Vehicle, conditions: Conditions) -> Fleet:
    """Return what all runs of a mission share."""
    scenario = mission.scenario
    both = zip(scenario.uavs, mission.trajectories, strict=True)
    flown = [trajectory is not None and uav.fixed_wing is None for uav, trajectory in both]
    told = tuple(commands_to(mission, uav, vehicle) if flies else None for uav, flies in enumerate(flown))
    end = max([float(c.times[-1]) for c in told if c is not None] + [mission.makespan])
    times = np.arange(np.ceil(end * COMMAND_RATE) + 1) / COMMAND_RATE
    still = tuple(None if flies else planned_places(mission, uav, times) for uav, flies in enumerate(flown))
    pairs = []
    for i, j in itertools.combinations(range(len(flown)), 2):
        level, upright = separation_of(mission, i, j)
        if level > 0 and (flown[i] or flown[j]):
            pairs.append((i, j, level, upright))
    world = World(derived(scenario, terrain=None))
    return Fleet(mission, vehicle, conditions, told, world, still, tuple(pairs))


def fly_run(fleet: Fleet, seed: int) -> SimulatedRun:
    """Fly every UAV of a mission once; the same seed flies the same."""
    scenario = fleet.mission.scenario
    seeds = run_seeds(seed, len(scenario.uavs))
    samples: list[Samples | None] = []
    errors: list[Floats | None] = []
    obstacle = ground = pair = NOWHERE
    outside = 0.0
    low, high = np.array(scenario.bounds.min), np.array(scenario.bounds.max)
    for uav, told in enumerate(fleet.commands):
        if told is None:
            samples.append(None)
            errors.append(None)
            continue
        flown = simulate(told, fleet.vehicle, fleet.conditions, seeds[uav])
        samples.append(flown)
        away = flown.positions - told.reference.position[told.hover :][: len(flown.times)]
        errors.append(np.column_stack([np.hypot(away[:, 0], away[:, 1]), np.abs(away[:, 2])]))
        obstacle = _nearer(obstacle, _nearest_obstacle(fleet.world, flown, uav))
        if scenario.terrain is not None:
            heights = flown.positions[:, 2] - scenario.terrain.height(flown.positions[:, :2])
            ground = _nearer(ground, _least(heights, flown, uav))
        outside = max(outside, float(np.max(low - flown.positions)), float(np.max(flown.positions - high)))
    both = zip(fleet.still, samples, strict=True)
    places: list[Floats] = [np.asarray(still) if f is None else f.positions for still, f in both]
    firsts = [0 if f is None else round(float(f.times[0]) * COMMAND_RATE) for f in samples]
    count = max(first + len(place) for first, place in zip(firsts, places, strict=True))
    nearness = np.inf
    for i, j, level, upright in fleet.pairs:
        apart = _held(places[i], firsts[i], count) - _held(places[j], firsts[j], count)
        across = apart[:, 0] ** 2 + apart[:, 1] ** 2
        squares = across + apart[:, 2] ** 2
        k = int(np.argmin(squares))
        between = np.linalg.norm(_between(apart, k), axis=1)
        pair = _nearer(pair, Nearest((i, j), k / COMMAND_RATE, float(between.min())))
        nearness = min(nearness, float(np.sqrt(np.min(across / level**2 + apart[:, 2] ** 2 / upright**2))))
    largest = np.array([np.zeros(2) if one is None else one.max(axis=0) for one in errors])
    lost = [(float(s.times[-1]), uav) for uav, s in enumerate(samples) if s is not None and s.lost]
    return SimulatedRun(
        seed,
        tuple(samples),
        tuple(errors),
        obstacle,
        ground,
        pair,
        nearness,
        outside,
        largest,
        min(lost, default=None),
    )


def _nearer(one: Nearest, other: Nearest) -> Nearest:
    return min(one, other, key=lambda near: (near.distance, near.time))


def run_seeds(seed: int, uavs: int) -> list[int]:
    """Return the seed of each UAV's flight in the run of a seed."""
    return np.random.default_rng(seed).integers(2**62, size=uavs).tolist()


def _nearest_obstacle(world: World, flown: Samples, uav: int) -> Nearest:
    """Return the least distance to an obstacle: of all samples, and around the nearest also between them."""
    distances = world.distance(flown.positions)
    k = int(np.argmin(distances))
    least = min(distances[k], world.distance(_between(flown.positions, k)).min())
    return Nearest((uav,) if np.isfinite(least) else (), float(flown.times[k]), float(least))


def _between(positions: Floats, k: int) -> Floats:
    """Return places on the straight lines from the sample before the k-th to it, and on to the one behind it."""
    before, at, after = positions[max(k - 1, 0)], positions[k], positions[min(k + 1, len(positions) - 1)]
    shares = np.linspace(0.0, 1.0, BETWEEN_SAMPLES)[:, None]
    return np.concatenate([before + shares * (at - before), at + shares * (after - at)])


def _least(distances: Floats, flown: Samples, uav: int) -> Nearest:
    k = int(np.argmin(distances))
    return Nearest((uav,), float(flown.times[k]), float(distances[k]))


def _held(positions: Floats, first: int, count: int) -> Floats:
    """Return (count, 3) positions: those given from a sample on, the first of them before and the last behind."""
    if len(positions) == count and first == 0:
        return positions
    return positions[np.clip(np.arange(count) - first, 0, len(positions) - 1)]


MILLIMETRES = 1000.0
"""The resolution of the distributions of errors, bins a metre."""


def added(one: Ints, other: Ints) -> Ints:
    """Return counts of errors of each millimetre, rounded up, and others together."""
    most = max(len(one), len(other))
    return np.pad(one, (0, most - len(one))) + np.pad(other, (0, most - len(other)))


def distribution(counts: Ints, largest: float) -> Distribution:
    """Return the distribution of errors that were counted, of which the largest is known exactly."""
    up_to = np.cumsum(counts)
    median, most = (float(np.searchsorted(up_to, share * up_to[-1])) / MILLIMETRES for share in (0.5, 0.99))
    return Distribution(min(median, largest), min(most, largest), largest)


def summarise_run(fleet: Fleet, seed: int) -> tuple[SimulatedRun, dict[int, tuple[Ints, Ints]]]:
    """Fly once; return what is kept, without samples and errors, and each UAV's counts of errors on both axes."""
    run = fly_run(fleet, seed)
    counts = {}
    for uav, errors in enumerate(run.errors):
        if errors is not None:
            bins = np.ceil(errors * MILLIMETRES).astype(np.int64)
            counts[uav] = (np.bincount(bins[:, 0]), np.bincount(bins[:, 1]))
    return run._replace(samples=(), errors=()), counts


def first_violation(fleet: Fleet, number: int, run: SimulatedRun) -> Violation | None:
    """Return the first thing that went wrong in a run, or nothing."""
    radius, names = fleet.vehicle.radius, [uav.name for uav in fleet.mission.scenario.uavs]
    wrong: list[tuple[float, str, Fault, tuple[int, ...], str]] = []
    for near, reach, deed, fault in (
        (run.obstacle, radius, "touches an obstacle", Fault.TRAJECTORY_CLEARANCE),
        (run.ground, radius, "touches the ground", Fault.TRAJECTORY_CLEARANCE),
        (run.pair, 2 * radius, "touch each other", Fault.SEPARATION),
    ):
        if near.distance <= reach:
            who = " and ".join(names[uav] for uav in near.uavs)
            wrong.append((near.time, f"{who} {deed}", fault, near.uavs, ""))
    if run.lost is not None:
        time, uav = run.lost
        flown = fleet.mission.trajectories[uav]
        assert flown is not None
        why = told_airspeeds(fleet.vehicle, flown, fleet.conditions.wind)
        deed = f"{names[uav]} is lost, more than {LOST_DISTANCE:g} m off its trajectory,"
        wrong.append((time, deed, Fault.TRAJECTORY_ENDS, (uav,), why))
    if not wrong:
        return None
    time, deed, fault, uavs, why = min(wrong)
    seed = f" (seed {run.seed})" if fleet.conditions.random else ""
    return Violation(fault, uavs, f"{deed} {told_instant(time)} in run {number}{seed}{why}", time)


CROSS_CHECKED = 3
"""How many of the runs that came nearest to obstacles, to the ground and to other UAVs are held against the referee."""
SECONDS_AROUND = 2.0
"""Seconds before and after the nearest instant that are judged."""
MORE = 0.001
"""Metres added to a measured distance, at which the referee must find something."""


def cross_check_nearest(fleet: Fleet, done: Sequence[SimulatedRun]) -> tuple[str, ...]:
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


def _agrees(fleet: Fleet, run: SimulatedRun, kind: str, nearest: Nearest) -> bool:
    """Tell whether the referee finds what was nearest at its distance, and nothing at a smaller one."""
    places = _around(fleet, run, nearest)
    if not _hit(fleet, kind, places, max(nearest.distance, 0.0) + MORE):
        return False
    steps = sum(float(np.linalg.norm(np.diff(rows, axis=0), axis=1).max(initial=0.0)) for rows in places)
    less = (nearest.distance - steps) / (math.sqrt(3.0) if kind == "obstacle" else 1.0) - MORE
    return less <= 0 or not _hit(fleet, kind, places, less)


def _around(fleet: Fleet, run: SimulatedRun, nearest: Nearest) -> list[Floats]:
    """Return where each UAV of the nearest instant is around it, (m, 3) metres, sample by sample."""
    first, last = nearest.time - SECONDS_AROUND, nearest.time + SECONDS_AROUND
    times = np.arange(np.floor(first * COMMAND_RATE), np.ceil(last * COMMAND_RATE) + 1) / COMMAND_RATE
    places = []
    for uav in nearest.uavs:
        flown, still = run.samples[uav], fleet.still[uav]
        known = np.asarray(still) if flown is None else flown.positions
        begin = 0 if flown is None else round(float(flown.times[0]) * COMMAND_RATE)
        rows = np.round(times * COMMAND_RATE).astype(int) - begin
        places.append(known[np.clip(rows, 0, len(known) - 1)])
    return places


def _hit(fleet: Fleet, kind: str, places: list[Floats], reach: float) -> bool:
    """Tell whether the referee finds a UAV within `reach` metres of an obstacle, the ground, or another UAV."""
    if kind == "pair":
        apart = places[0] - places[1]
        return bool(distance_to_segment(np.zeros((len(apart) - 1, 3)), apart[:-1], apart[1:]).min() <= reach)
    scenario = fleet.mission.scenario
    changes: dict[str, object] = {"clearance": reach, "max_height": None}
    if kind == "obstacle":
        changes |= {"terrain": None}
    else:
        changes |= {"obstacles": (), "terrain": scenario.terrain and derived(scenario.terrain, clearance=reach)}
    (rows,) = places
    return judge_segments(referee_world(derived(scenario, **changes)), rows[:-1], rows[1:]).incursion is not None
