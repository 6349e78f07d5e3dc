"""Flights that are replanned among movers and walls that nobody knows of: ``python benchmarks/replanning.py``.

UAVs see movers within ``--range`` metres, ``--rate`` times a second, and fly exactly what the replanner answers. The
table tells for each world and kind of movers: how many flights arrive; how many the referee proves, among the movers as
they truly move; the flights in which one of them is touched, by whether full knowledge would have shown an escape from
it when it was first seen; answers without a proven way out; the time of flight over its proven lower bound; and the
milliseconds of one replan. Of fleets that do not arrive it tells how many still do not a minute after all movers have
vanished: those whose UAVs keep each other from going on. Worlds are built-in scenarios, ``hall``, ``forest``,
``forest-swap`` and ``maze`` of an even number of UAVs of 3 m/s, ``block``, a part of a downtown, and ``field``, which
aeroplanes of 15 m/s cross; ``walls`` as a kind of movers are walls that stand still and are not known.
"""

import argparse
import statistics
import time
from collections.abc import Iterator
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass, field, replace
from functools import cache
from typing import get_args

import numpy as np
from escapes import contacts
from machine import describe, table

import skyverse as sky
from skyverse.lab import Case, least_lengths, least_seconds
from skyverse.samples.movers import MoverKind

KINDS = (*get_args(MoverKind), "walls")
WALL = (0.2, 2.0)
"""Metres: how thick and how wide walls are."""


def hall(uavs: int) -> sky.Scenario:
    """Return an empty hall that UAVs of 1 m/s cross."""
    y = np.linspace(0, 12, uavs + 2)[1:-1]
    return sky.Scenario(
        name="hall",
        bounds=sky.Bounds(min=(0, 0, 0), max=(20, 12, 4)),
        clearance=0.1,
        lattice=sky.Lattice(step=(0.5, 0.5, 0.5), connectivity=26),
        objective=sky.Objective(unit="metres"),
        uavs=[sky.UAV(start=(1, place, 1.5), max_speed=1.0, separation=0.4) for place in y],
        targets=[sky.Target(position=(19, place, 1.5)) for place in y],
    )


def forest(seed: int, uavs: int) -> sky.Scenario:
    """Return trunks on 10 m x 10 m, across which UAVs exchange sides, half of them from either one."""
    rng = np.random.default_rng(seed)
    trunks = [(*rng.uniform((1.5, 0), (8.5, 10)), rng.uniform(0.1, 0.3)) for _ in range(20)]
    sides = [[(x, y, 1.5) for y in np.linspace(0.5, 9.5, (uavs + 1) // 2)] for x in (0.5, 9.5)]
    near, far = sides[0][: (uavs + 1) // 2], sides[1][: uavs // 2]
    across = [(10 - x, 10 - y, z) for x, y, z in near + far]
    return sky.Scenario(
        name=f"forest-{seed}",
        bounds=sky.Bounds(min=(0, 0, 0), max=(10, 10, 3)),
        obstacles=[sky.Cylinder(centre=(x, y), radius=r, low=0, high=3) for x, y, r in trunks],
        clearance=0.1,
        lattice=sky.Lattice(step=(0.25, 0.25, 0.25), connectivity=26),
        objective=sky.Objective(unit="metres"),
        uavs=[sky.UAV(start=place, max_speed=1.0, separation=0.4) for place in near + far],
        targets=[sky.Target(position=place) for place in across],
    )


def block(seed: int, uavs: int) -> sky.Scenario:
    """Return a part of a downtown, 250 m x 250 m; the seeds of those in which a target is shut in are passed over."""
    for number in range(1000 * seed, 1000 * seed + 1000):
        scenario = sky.random_downtown(30, side=250.0, uavs=uavs, seed=number)
        if reachable(scenario):
            return scenario
    raise ValueError("no block of which all targets can be reached")


def aeroplane_field(seed: int, uavs: int) -> sky.Scenario:
    """Return a field of 600 m x 400 m with four houses, which aeroplanes cross."""
    wing = sky.FixedWing(speed=15, turn_radius=40, climb=12)
    y = np.linspace(0, 400, uavs + 2)[1:-1]
    for number in range(1000 * seed, 1000 * seed + 1000):
        rng = np.random.default_rng(number)
        corners, sizes = (
            rng.uniform((120, 40, 0), (440, 320, 0), (4, 3)),
            rng.uniform((10, 10, 20), (50, 50, 120), (4, 3)),
        )
        scenario = sky.Scenario(
            name=f"field-{number}",
            bounds=sky.Bounds(min=(0, 0, 0), max=(600, 400, 120)),
            obstacles=[sky.Box(min=low, max=low + size) for low, size in zip(corners, sizes, strict=True)],
            clearance=3,
            lattice=sky.Lattice(step=(10, 10, 10), connectivity=26),
            objective=sky.Objective(unit="metres"),
            uavs=[
                sky.UAV(start=(40, at, 30), max_speed=16, max_acceleration=7, separation=10, fixed_wing=wing)
                for at in y
            ],
            targets=[sky.Target(position=(540, at, 60)) for at in y[::-1]],
        )
        if not planned(scenario).violations:
            return scenario
    raise ValueError("no field that aeroplanes can cross")


@cache
def planned(scenario: sky.Scenario) -> sky.Mission:
    return sky.plan_mission(scenario, assignment="identity")


def reachable(scenario: sky.Scenario) -> bool:
    """Tell whether all UAVs have a proven way to their targets."""
    mission = planned(scenario)
    return not mission.violations and all(one is not None and one.status.reached for one in mission.results)


def world(name: str, seed: int, uavs: int, speed: float | None) -> sky.Scenario:
    """Return a world, with UAVs of another top speed if one is given."""
    if name == "hall":
        scenario = hall(uavs)
    elif name == "forest":
        scenario = forest(seed, uavs)
    elif name in ("forest-swap", "maze"):
        scenario = (sky.random_maze if name == "maze" else sky.forest_swap)(uavs, seed=seed)
    elif name == "block":
        scenario = block(seed, uavs)
    elif name == "field":
        scenario = aeroplane_field(seed, uavs)
    else:
        scenario = sky.read(name)
    if speed is None:
        return scenario
    faster = tuple(uav.model_copy(update={"max_speed": speed}) for uav in scenario.uavs)
    return scenario.model_copy(update={"uavs": faster})


def with_walls(mission: sky.Mission, count: int, seed: int) -> sky.Scenario:
    """Return a scenario with walls on the ways of a mission, away from starts and targets."""
    rng, scenario = np.random.default_rng(seed), mission.scenario
    ends = np.array([*(uav.start for uav in scenario.uavs), *(one.position for one in scenario.targets)])
    walls: list[sky.Box] = []
    for _ in range(1000 * count):
        if len(walls) == count:
            break
        way = mission.trajectories[rng.integers(len(scenario.uavs))]
        if way is None:
            continue
        middle = way.at([rng.uniform(way.start, way.end)]).position[0]
        size = np.array(WALL if rng.random() < 0.5 else WALL[::-1]) / 2
        if np.linalg.norm(ends - middle, axis=1).min() < 2.0 + 2.0 * scenario.clearance:
            continue
        low = (*(middle[:2] - size), scenario.bounds.min[2])
        walls.append(sky.Box(min=low, max=(*(middle[:2] + size), scenario.bounds.max[2])))
    truth = sky.Scenario(**{**dict(scenario), "obstacles": (*scenario.obstacles, *walls)})
    return truth if reachable(truth) else with_walls(mission, max(count - 1, 0), seed + 1)


def lower_bound(scenario: sky.Scenario, assignment: tuple[int | None, ...]) -> float:
    """Return seconds before which not all UAVs can have arrived, whatever moves: by lengths that are proven least."""
    lengths = least_lengths(Case("", scenario), assignment)
    return max(least_seconds(length, uav) for length, uav in zip(lengths, scenario.uavs, strict=True))


@dataclass
class Flown:
    """What came of one flight."""

    arrived: bool
    deadlocked: bool
    proven: bool
    touched: str
    over_bound: float
    answers: list[tuple[float, bool, str]] = field(repr=False)


def fly(name: str, kind: str, seed: int, given: argparse.Namespace) -> Flown:
    """Fly once."""
    mission = planned(world(name, seed, given.uavs, given.uav_speed))
    scenario = mission.scenario
    if kind == "walls":
        truth = with_walls(mission, given.movers, seed)
    else:
        truth = sky.random_movers(
            scenario, given.movers, kind=kind, speed=given.speed, radius=given.radius, seed=seed
        )  # fmt: skip
    replanner = sky.Replanner(mission)
    answers: list[sky.Replan] = []
    sensor = sky.Sensor(range=given.range, rate=given.rate, error=given.error)
    longest = 3.0 * mission.makespan + 30.0
    arrived = sky.fly_closed_loop(replanner, truth, sensor, longest=longest, rng=seed, on_answers=answers.extend)
    flown = tuple(replanner.flown(uav) for uav in range(len(scenario.uavs)))
    judged = sky.certify(truth, replace(mission, scenario=truth, trajectories=flown))
    found = [*judged.trajectories, judged.apart]
    wrong = [one for one in found if one is not None and one.verdict is not sky.Verdict.PROVEN]
    touched = ""
    if wrong:
        touched = contacts(replanner, truth, sensor)
    bound = lower_bound(truth.model_copy(update={"movers": ()}), mission.assignment)
    ends = [replanner.arrival(uav) or np.inf for uav in range(len(scenario.uavs))]
    told = [(1e3 * one.seconds, one.proven, one.sentence) for one in answers]
    deadlocked = not arrived and is_deadlocked(replanner, given.rate)
    if given.verbose and (wrong or not arrived):
        said = "; ".join(one.sentence for one in wrong)
        print(
            f"{name} {kind} seed {seed}: arrived {arrived}, deadlocked {deadlocked}, touched {touched}; {said}",
            flush=True,
        )
    return Flown(arrived, deadlocked, not wrong, touched, max(ends) / bound, told)


def is_deadlocked(replanner: sky.Replanner, rate: float) -> bool:
    """Tell whether UAVs that have not arrived still do not in a minute in which no mover is seen."""
    uavs = range(len(replanner.mission.scenario.uavs))
    for _ in range(int(60.0 * rate)):
        replanner.observe(replanner.now + 1.0 / rate, gone=[mover.name for mover in replanner.predicted()])
        if all((replanner.arrival(uav) or np.inf) <= replanner.now for uav in uavs):
            return False
    return True


def row(name: str, kind: str, given: argparse.Namespace, flights: Iterator[Flown]) -> list[str]:
    """Return a row of the table."""
    all_flown = list(flights)
    times = [one.over_bound for one in all_flown if one.arrived]
    answers = [answer for one in all_flown for answer in one.answers]
    milliseconds = np.percentile([answer[0] for answer in answers], [50, 99, 100])
    touched = [sum(one.touched == what for one in all_flown) for what in ("escape", "no escape")]
    return [
        name,
        kind,
        f"{sum(one.arrived for one in all_flown)} of {len(all_flown)}",
        f"{sum(one.deadlocked for one in all_flown)}",
        f"{sum(one.proven for one in all_flown)}",
        f"{touched[0]}, {touched[1]}",
        f"{sum(not answer[1] for answer in answers)} of {len(answers)}",
        f"{statistics.median(times):.2f}, {max(times):.2f}" if times else "",
        *(f"{value:.1f}" for value in milliseconds),
    ]


def main() -> None:
    """Fly among movers of each kind in the worlds asked for."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("worlds", nargs="*", default=["map1", "map2", "map3"])
    parser.add_argument("--kinds", nargs="*", default=KINDS, choices=KINDS)
    parser.add_argument("--count", type=int, default=10, help="flights of each kind; 10 by default")
    parser.add_argument("--movers", type=int, default=10, help="movers, or walls, in each; 10 by default")
    parser.add_argument("--speed", type=float, default=0.5, help="their mean speed, m/s; 0.5 by default")
    parser.add_argument("--radius", type=float, help="their radius, m; a hundredth of the world's side by default")
    parser.add_argument("--uavs", type=int, default=1, help="UAVs in built worlds; 1 by default")
    parser.add_argument("--uav-speed", type=float, help="their top speed, m/s; the scenario's by default")
    parser.add_argument("--seeds", type=int, default=51_000, metavar="FROM", help="the first seed; 51000 by default")
    parser.add_argument("--rate", type=float, default=10.0, help="observations a second; 10 by default")
    parser.add_argument("--range", type=float, default=8.0, help="metres in which is seen; 8 by default")
    parser.add_argument("--error", type=float, default=0.0, help="of positions seen, metres; 0 by default")
    parser.add_argument("--jobs", type=int, default=1, help="processes; 1 by default")
    parser.add_argument("--verbose", action="store_true", help="tell each flight that is not proven")
    given = parser.parse_args()
    print(f"{describe()}\n")
    rows, seeds, began = [], range(given.seeds, given.seeds + given.count), time.perf_counter()
    with ProcessPoolExecutor(given.jobs) as pool:
        for name in given.worlds:
            for kind in given.kinds:
                many = [[one] * given.count for one in (name, kind, given)]
                run = pool.map if given.jobs > 1 else map
                rows.append(row(name, kind, given, run(fly, many[0], many[1], seeds, many[2])))
    head = ["world", "movers", "arrived", "deadlocked", "proven", "touched: with, without an escape", "without way out"]
    table([*head, "time over bound: median, worst", "ms: median", "99 %", "worst"], rows)
    print(f"{time.perf_counter() - began:.0f} s")


if __name__ == "__main__":
    main()
