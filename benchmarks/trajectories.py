"""Smooth trajectories against stop-and-go and against toppra's bound: ``python benchmarks/trajectories.py [NAME ...]``.

Each path is flown in three ways within the same limits: smoothly with little snap, smoothly with little jerk, and at
rest at every waypoint. A lower bound for any flight along the smooth trajectory's own curve is toppra's time-optimal
parameterisation of it (see `fastest.py`), which keeps the limits on speed and acceleration but none on jerk. The times
to make and to prove a trajectory are medians over several calls, in milliseconds of this process on one core, after a
call that compiles.
"""

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
from skyverse.numerics.tolerances import SEAM_MARGIN
from skyverse.search.path_shortening.shortcut import drop_collinear, shortcut
from skyverse.space.obstacles import with_margin
from skyverse.trajectory import Shape, fly_along
from skyverse.trajectory.corridor import grow_corridor
from skyverse.trajectory.proof import prove
from skyverse.trajectory.smooth import REACH

MAPS = ("map1", "map2", "map3")
FLEETS = ("table-4.8", "table-4.9-2", "table-4.9-3", "table-4.9-4", "table-4.11", "table-4.12", "table-4.13")
PLANNERS = {"Taut": sky.Taut(), "A*": sky.AStar(), "MVO": sky.MVO()}
SHAPES: tuple[Shape, ...] = ("minimum-snap", "minimum-jerk")
CITIES, ROOMS = 5, 20


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


def paths(name: str) -> Iterator[tuple[str, sky.Problem, sky.Result]]:
    """Yield planner, problem and result for each path of a map, a fleet, or a set of random scenarios."""
    if name == "cities":
        scenarios = [sky.random_city(500, seed=seed) for seed in range(CITIES)]
        planners = ["Taut"]
    elif name == "rooms":
        scenarios = [sky.random_room(seed=seed) for seed in range(ROOMS)]
        planners = ["Taut", "A*"]
    else:
        scenarios = [sky.read(name)]
        planners = list(PLANNERS)
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


def segments(problem: sky.Problem, result: sky.Result) -> int:
    """Count the boxes of the corridor along a path."""
    ends = problem.scenario.uavs[problem.uav].start, problem.scenario.targets[problem.target].position
    waypoints = drop_collinear(np.vstack([ends[0], result.path, ends[1]]))
    world = problem.airspace.world
    return len(grow_corridor(world.space, shortcut(with_margin(world.space, SEAM_MARGIN), waypoints), REACH, math.inf))


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
        f"{sum(f.form == 'smooth' for f in flown)} of {len(flown)}",
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


HEAD = ["case", "paths by", "smooth", "proven", "stop-and-go", "smooth", "toppra", "smooth / stop-and-go (most)"]
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
        rows, everything = [], []
        for name in names:
            flights: dict[str, list[Flown]] = {}
            for planner, problem, result in paths(name):
                flights.setdefault(planner, []).append(fly(problem, result, shape))
            rows += [row(name, planner, flown) for planner, flown in flights.items()]
            everything += [f for flown in flights.values() for f in flown]
        print(f"{shape}:\n")
        table(HEAD, [*rows, row("all", "", everything)])


if __name__ == "__main__":
    print(f"{describe('scipy', 'toppra')}\n")
    main(sys.argv[1:] or [*MAPS, *FLEETS, "cities", "rooms"])
