"""Trajectories against stop-and-go and toppra's bound: ``python benchmarks/trajectories.py [NAME ...]``.

Each path is flown in three ways within the same limits: in the least time near it, as a spline with little snap, and at
rest at every waypoint. A lower bound for any flight along the trajectory's own curve is toppra's time-optimal
parameterisation of it (see `fastest.py`), which keeps the limits on speed and acceleration but none on jerk. The times
to make and to prove a trajectory are medians over several calls, in milliseconds of this process on one core, after a
call that compiles.

A second table compares what is flown with the path that was planned: length, turning, changes between climbing and
descending, the largest distance between the two, and the time over that of a profile of seven segments, in each of
which the jerk is constant, on a straight line as long as the path.
"""

import itertools
import math
import statistics
import sys
import time
from collections.abc import Callable, Iterator
from typing import NamedTuple

import numpy as np
from fastest import least_time
from machine import describe, table

import skyverse as sky
from skyverse.model.verdict import Verdict
from skyverse.search.path_shortening.shortcut import drop_collinear, shortcut
from skyverse.summary import flight_summary
from skyverse.trajectory import Shape, fly_along
from skyverse.trajectory.corridor import grow_corridor
from skyverse.trajectory.proof import prove
from skyverse.trajectory.smooth import REACH

MAPS = ("map1", "map2", "map3")
FLEETS = ("table-4.8", "table-4.9-2", "table-4.9-3", "table-4.9-4", "table-4.11", "table-4.12", "table-4.13")
PLANNERS = {"Taut": sky.Taut(), "A*": sky.AStar(), "MVO": sky.MVO(), "Cheapest": sky.Cheapest()}
SHAPES: tuple[Shape, ...] = ("minimum-time", "minimum-snap")
CITIES, ROOMS, COURSES = 5, 20, 12
STILL = 0.01
"""Metres per second of climb or descent that count as level flight."""
STRAIGHT = 1e-5
"""Radians between two directions that count as the same one, since positions are rounded."""


class Flown(NamedTuple):
    """One path, flown in three ways: seconds of each flight; the smooth one, how long it takes to make and to prove."""

    form: str
    smooth: float
    stopping: float
    least: float
    milliseconds: float
    segments: int
    proven: bool
    proof: float
    kept: "Kept"


class Kept(NamedTuple):
    """What is flown beside what was planned: metres, degrees of turning, reversals of climb, seconds."""

    length: float
    path_length: float
    turning: float
    path_turning: float
    reversals: int
    path_reversals: int
    distance: float
    profile: float


def kept(uav: sky.UAV, path: np.ndarray, flown: sky.Trajectory) -> Kept:
    """Compare a flight with its path."""
    summary = flight_summary(uav, path, flown)
    instants = np.concatenate([np.linspace(a, b, 30, endpoint=False) for a, b in itertools.pairwise(flown.knots)])
    velocity = flown.at(instants).velocity
    velocity = velocity[np.linalg.norm(velocity, axis=1) > STILL]
    steps = np.diff(path, axis=0)
    steps = steps[np.linalg.norm(steps, axis=1) > 0.0]
    length = float(np.linalg.norm(steps, axis=1).sum())
    return Kept(
        summary.length,
        length,
        turning(velocity),
        turning(steps),
        reversals(velocity[:, 2]),
        reversals(steps[:, 2]),
        summary.deviation,
        profile_seconds(length, uav),
    )


def turning(ways: np.ndarray) -> float:
    """Return the sum of the angles between successive directions, degrees."""
    ways = ways / np.linalg.norm(ways, axis=1)[:, None]
    angles = 2.0 * np.arcsin(np.clip(np.linalg.norm(np.diff(ways, axis=0), axis=1) / 2.0, 0.0, 1.0))
    return math.degrees(angles[angles > STRAIGHT].sum())


def reversals(climbs: np.ndarray) -> int:
    """Count the changes between climb and descent."""
    signs = np.sign(climbs[np.abs(climbs) > STILL])
    return int(np.count_nonzero(np.diff(signs)))


def profile_seconds(length: float, uav: sky.UAV) -> float:
    """Return the least time from rest to rest on a level line, with speed, acceleration and jerk limited."""

    def way(peak: float) -> float:
        return peak * ramp(peak)

    def ramp(peak: float) -> float:
        a, j = min(uav.max_acceleration, 9.81 * math.tan(math.radians(uav.max_tilt))), uav.max_jerk
        return peak / a + a / j if peak >= a * a / j else 2.0 * math.sqrt(peak / j)

    peak = uav.max_speed
    if way(peak) > length:
        low, high = 0.0, peak
        for _ in range(100):
            peak = 0.5 * (low + high)
            low, high = (peak, high) if way(peak) < length else (low, peak)
    return 2.0 * ramp(peak) + (length - way(peak)) / peak if length else 0.0


def paths(name: str) -> Iterator[tuple[str, sky.Problem, sky.Result]]:
    """Yield planner, problem and result for each path of a map, a fleet, or a set of random scenarios."""
    if name == "cities":
        scenarios = [sky.random_city(500, seed=seed) for seed in range(CITIES)]
        planners = ["Taut"]
    elif name == "rooms":
        scenarios = [sky.random_room(seed=seed) for seed in range(ROOMS)]
        planners = ["Taut", "A*"]
    elif name == "jacksboro":
        scenarios = [sky.read(name)]
        planners = ["Taut", "Cheapest"]
    elif name == "mountains":
        scenarios = [mountains()]
        planners = ["Taut"]
    elif name == "field":
        scenarios = [field()]
        planners = ["Taut"]
    else:
        scenarios = [sky.read(name)]
        planners = ["Taut", "A*", "MVO"]
    for planner in planners:
        for scenario in scenarios:
            starts = [uav.start for uav in scenario.uavs]
            targets = [target.position for target in scenario.targets]
            airspace = sky.Airspace(scenario)
            for uav, target in enumerate(sky.assign(sky.straight_line(starts, targets))):
                if target is not None:
                    problem = sky.Problem(airspace, uav, target)
                    result = PLANNERS[planner].plan(problem, rng=1)
                    if result.status.reached:
                        yield planner, problem, result


def mountains() -> sky.Scenario:
    """Make steep mountains of 10 m cells on 5 km x 5 km, up to 1,300 m high, and six courses over them."""
    rng = np.random.default_rng(7)
    count = 500
    waves = np.fft.rfftfreq(count)[None, :] ** 2 + np.fft.fftfreq(count)[:, None] ** 2
    strength = np.where(waves > 0.0, np.maximum(waves, 1e-9) ** -0.95, 0.0)
    phases = np.exp(2j * math.pi * rng.random(waves.shape))
    heights = np.fft.irfft2(strength * phases, s=(count, count))
    heights = 1300.0 * (heights - heights.min()) / np.ptp(heights)
    terrain = sky.Terrain(origin=(0.0, 0.0), step=(10.0, 10.0), heights=heights, clearance=30.0)
    rows = [((300, 400), (4600, 4500)), ((4500, 300), (400, 4300)), ((300, 2500), (4700, 2200))]
    rows += [((2500, 300), (2300, 4700)), ((500, 4000), (3900, 900)), ((1000, 1500), (4400, 3100))]

    def above(place: tuple[int, int]) -> tuple[float, float, float]:
        return (float(place[0]), float(place[1]), float(heights[place[0] // 10, place[1] // 10]) + 60.0)

    return sky.Scenario(
        name="mountains",
        bounds=sky.Bounds(min=(0, 0, 0), max=(4990, 4990, 1800)),
        terrain=terrain,
        clearance=10.0,
        lattice=sky.Lattice(step=(50, 50, 50), connectivity=26),
        objective=sky.Objective(unit="metres"),
        uavs=[sky.UAV(start=above(start), max_speed=15.0) for start, _ in rows],
        targets=[sky.Target(position=above(end)) for _, end in rows],
    )


def field() -> sky.Scenario:
    """Make an open field, and courses across it that slant in all ways."""
    rng = np.random.default_rng(3)
    ends = rng.uniform((0, 0, 20), (2000, 2000, 120), (COURSES, 2, 3))
    return sky.Scenario(
        name="field",
        bounds=sky.Bounds(min=(0, 0, 0), max=(2000, 2000, 150)),
        clearance=2.0,
        lattice=sky.Lattice(step=(20, 20, 10), connectivity=26),
        objective=sky.Objective(unit="metres"),
        uavs=[sky.UAV(start=tuple(start), max_speed=5.0 + k) for k, (start, _) in enumerate(ends.tolist())],
        targets=[sky.Target(position=tuple(end)) for _, end in ends.tolist()],
    )


def segments(problem: sky.Problem, result: sky.Result) -> int:
    """Count the boxes of the corridor along a path."""
    ends = problem.scenario.uavs[problem.uav].start, problem.scenario.targets[problem.target].position
    waypoints = drop_collinear(np.vstack([ends[0], result.path, ends[1]]))
    world = problem.airspace.world
    return len(grow_corridor(world.space, shortcut(world.space, waypoints), REACH, math.inf))


def milliseconds(call: Callable[[], object], runs: int) -> float:
    """Return the median CPU time of a call, milliseconds, after a call that is not counted."""
    call()
    spent = []
    for _ in range(runs):
        began = time.process_time()
        call()
        spent.append(time.process_time() - began)
    return statistics.median(spent) * 1e3


def fly(problem: sky.Problem, result: sky.Result, shape: Shape) -> Flown:
    """Fly one path in three ways and measure the times."""
    uav = problem.scenario.uavs[problem.uav]
    smooth = fly_along(problem, result, shape)
    stopping = fly_along(problem, result, "stop-and-go")
    return Flown(
        smooth.form,
        smooth.end - smooth.start,
        stopping.end - stopping.start,
        least_time(smooth, uav),
        milliseconds(lambda: fly_along(problem, result, shape), 5),
        segments(problem, result),
        prove(problem.airspace.world, uav, smooth).verdict is Verdict.PROVEN,
        milliseconds(lambda: prove(problem.airspace.world, uav, smooth), 9),
        kept(uav, np.vstack([problem.start, result.path, problem.end]), smooth),
    )


def row(name: str, planner: str, flown: list[Flown]) -> list[str]:
    """Return the table's row for the flights along one planner's paths."""
    faster = [f.smooth / f.stopping for f in flown]
    at_best = [f.least / f.stopping for f in flown]
    above = [f.smooth / f.least for f in flown]
    per_ten = [f.milliseconds / max(f.segments, 1) * 10 for f in flown]
    return [
        name,
        planner,
        f"{sum(f.form == 'blended' for f in flown)}, {sum(f.form == 'smooth' for f in flown)} of {len(flown)}",
        f"{sum(f.proven for f in flown)}",
        f"{sum(f.stopping for f in flown):.1f} s",
        f"{sum(f.smooth for f in flown):.1f} s",
        f"{sum(f.least for f in flown):.1f} s",
        f"{statistics.median(faster):.3f} ({max(faster):.3f})",
        f"{statistics.median(at_best):.3f} ({max(at_best):.3f})",
        f"{statistics.median(above):.3f} ({max(above):.3f})",
        f"{statistics.median(f.segments for f in flown):g}",
        f"{statistics.median(f.milliseconds for f in flown):.1f} ms",
        f"{statistics.median(per_ten):.1f} ms ({max(per_ten):.1f} ms)",
        f"{statistics.median(f.proof for f in flown):.2f} ms",
    ]


def shape_row(name: str, planner: str, flown: list[Flown]) -> list[str]:
    """Return the second table's row for the flights along one planner's paths."""
    longer = [f.kept.length / f.kept.path_length for f in flown]
    more = [f.kept.turning - f.kept.path_turning for f in flown]
    slower = [f.smooth / f.kept.profile for f in flown]
    away = [f.kept.distance for f in flown]
    return [
        name,
        planner,
        f"{sum(f.kept.path_length for f in flown):.0f} m",
        f"{statistics.median(longer):.4f} ({max(longer):.4f})",
        f"{sum(f.kept.path_turning for f in flown):.0f}",
        f"{sum(f.kept.turning for f in flown):.0f}",
        f"{max(more):.0f}",
        f"{sum(f.kept.path_reversals for f in flown)}",
        f"{sum(f.kept.reversals for f in flown)}",
        f"{statistics.median(away):.2f} m ({max(away):.2f} m)",
        f"{statistics.median(slower):.3f} ({max(slower):.3f})",
    ]


SHAPE_HEAD = ["case", "paths by", "paths", "flown / path (most)", "degrees of the paths", "flown", "most added"]
SHAPE_HEAD += ["reversals of climb", "flown", "distance (most)", "time / profile (most)"]
HEAD = [
    "case",
    "paths by",
    "blended, smooth",
    "proven",
    "stop-and-go",
    "smooth",
    "toppra",
    "smooth / stop-and-go (most)",
]
HEAD += [
    "toppra / stop-and-go (most)",
    "smooth / toppra (most)",
    "segments",
    "to make",
    "per 10 segments (most)",
    "to prove",
]


def main(names: list[str]) -> None:
    """Print a table for each shape of trajectory."""
    for shape in SHAPES:
        rows, shapes, everything = [], [], []
        for name in names:
            flights: dict[str, list[Flown]] = {}
            for planner, problem, result in paths(name):
                flights.setdefault(planner, []).append(fly(problem, result, shape))
            rows += [row(name, planner, flown) for planner, flown in flights.items()]
            shapes += [shape_row(name, planner, flown) for planner, flown in flights.items()]
            everything += [f for flown in flights.values() for f in flown]
        print(f"{shape}:\n")
        table(HEAD, [*rows, row("all", "", everything)])
        table(SHAPE_HEAD, [*shapes, shape_row("all", "", everything)])


if __name__ == "__main__":
    print(f"{describe('scipy', 'toppra')}\n")
    main(sys.argv[1:] or [*MAPS, *FLEETS, "cities", "rooms", "jacksboro", "mountains", "field"])
