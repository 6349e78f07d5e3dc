"""One run of a whole mission in the compiled simulator: errors, distances, and what was touched."""

import itertools
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from skyverse._typing import Floats
from skyverse.flight.commands import COMMAND_RATE, Commands, commands
from skyverse.flight.simulate import Samples, SimulationJob, simulate
from skyverse.flight.vehicle import Vehicle
from skyverse.flight.weather import Weather
from skyverse.model.mission import Mission
from skyverse.model.quantities import derived
from skyverse.space.world import World


@dataclass(frozen=True, eq=False)
class Fleet:
    """What all runs of a mission share.

    Attributes
    ----------
    mission, vehicle, weather
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
    weather: Weather
    commands: tuple[Commands | None, ...]
    world: World
    still: tuple[Floats | None, ...]
    pairs: tuple[tuple[int, int, float, float], ...]


class Nearest(NamedTuple):
    """The least distance that something came to: metres, seconds into the mission, and who came there."""

    distance: float
    time: float
    uavs: tuple[int, ...]


class Run(NamedTuple):
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
    """

    seed: int
    samples: tuple[Samples | None, ...]
    errors: tuple[Floats | None, ...]
    obstacle: Nearest
    ground: Nearest
    pair: Nearest
    nearness: float
    outside: float


BETWEEN_SAMPLES = 11
"""Places between two samples at which the least distance is looked for."""
NOWHERE = Nearest(np.inf, 0.0, ())
"""What stands where there is nothing to come near to."""


def prepare(mission: Mission, vehicle: Vehicle, weather: Weather) -> Fleet:
    """Return what all runs of a mission share."""
    scenario = mission.scenario
    both = zip(scenario.uavs, mission.trajectories, strict=True)
    flown = [trajectory is not None and uav.fixed_wing is None for uav, trajectory in both]
    told = tuple(commands(mission, uav, vehicle) if flies else None for uav, flies in enumerate(flown))
    end = max([float(c.times[-1]) for c in told if c is not None] + [mission.makespan])
    times = np.arange(np.ceil(end * COMMAND_RATE) + 1) / COMMAND_RATE
    still = []
    for uav, flies in enumerate(flown):
        trajectory = mission.trajectories[uav]
        start = np.array([scenario.uavs[uav].start], dtype=np.float64)
        still.append(None if flies else start if trajectory is None else trajectory.at(times).position)
    pairs = []
    for i, j in itertools.combinations(range(len(flown)), 2):
        level, upright = np.maximum(scenario.uavs[i].ellipsoid, scenario.uavs[j].ellipsoid).tolist()
        if level > 0 and (flown[i] or flown[j]):
            pairs.append((i, j, level, upright))
    world = World(derived(scenario, terrain=None))
    return Fleet(mission, vehicle, weather, told, world, tuple(still), tuple(pairs))


def fly_run(fleet: Fleet, seed: int) -> Run:
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
        flown = simulate(SimulationJob(told, fleet.vehicle, fleet.weather, seeds[uav]))
        samples.append(flown)
        away = flown.positions - told.reference.position[told.hover :][: len(flown.times)]
        errors.append(np.column_stack([np.hypot(away[:, 0], away[:, 1]), np.abs(away[:, 2])]))
        obstacle = min(obstacle, _nearest_obstacle(fleet.world, flown, uav))
        if scenario.terrain is not None:
            heights = flown.positions[:, 2] - scenario.terrain.height(flown.positions[:, :2])
            ground = min(ground, _least(heights, flown, uav))
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
        pair = min(pair, Nearest(float(between.min()), k / COMMAND_RATE, (i, j)))
        nearness = min(nearness, float(np.sqrt(np.min(across / level**2 + apart[:, 2] ** 2 / upright**2))))
    return Run(seed, tuple(samples), tuple(errors), obstacle, ground, pair, nearness, outside)


def run_seeds(seed: int, uavs: int) -> list[int]:
    """Return the seed of each UAV's flight in the run of a seed."""
    return np.random.default_rng(seed).integers(2**62, size=uavs).tolist()


def _nearest_obstacle(world: World, flown: Samples, uav: int) -> Nearest:
    """Return the least distance to an obstacle: of all samples, and around the nearest also between them."""
    distances = world.distance(flown.positions)
    k = int(np.argmin(distances))
    least = min(distances[k], world.distance(_between(flown.positions, k)).min())
    return Nearest(float(least), float(flown.times[k]), (uav,) if np.isfinite(least) else ())


def _between(positions: Floats, k: int) -> Floats:
    """Return places on the straight lines from the sample before the k-th to it, and on to the one behind it."""
    before, at, after = positions[max(k - 1, 0)], positions[k], positions[min(k + 1, len(positions) - 1)]
    shares = np.linspace(0.0, 1.0, BETWEEN_SAMPLES)[:, None]
    return np.concatenate([before + shares * (at - before), at + shares * (after - at)])


def _least(distances: Floats, flown: Samples, uav: int) -> Nearest:
    k = int(np.argmin(distances))
    return Nearest(float(distances[k]), float(flown.times[k]), (uav,))


def _held(positions: Floats, first: int, count: int) -> Floats:
    """Return (count, 3) positions: those given from a sample on, the first of them before and the last behind."""
    if len(positions) == count and first == 0:
        return positions
    return positions[np.clip(np.arange(count) - first, 0, len(positions) - 1)]
