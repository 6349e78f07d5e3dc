"""The default planner beside all others that price the same: ``python benchmarks/default.py [FIELD ...]``.

The fields are the built-in scenarios, random threats, downtowns, flights over the terrain of Jacksboro between random
places, and ways among many cylinders, spheres and prisms; ``--count`` and ``--seeds`` say how many of each, and the
first seed. A field's table holds, for each planner, its costs divided by the lowest that any of them finds: the median,
the worst, and the share within 0.5 %. Paths that differ in their ends or units are not compared: lattice paths are
compared where nodes are priced, straight legs elsewhere. The referee's `check_result` prices every path anew, and an
answer that it finds wrong ends the program; so does a bound that a path of another planner beats.
"""

import argparse
import statistics
from collections import defaultdict
from collections.abc import Iterator

import numpy as np
from machine import describe, table

import skyverse as sky
from skyverse.files.builtin import BUILTIN_NAMES
from skyverse.mission.assignment import assign_targets

NEAR = 0.005
ROUNDING = 1e-9
BUDGET = sky.MaxEvaluations(10_000)
STRAIGHT = {
    "Taut": sky.Taut(),
    "ThetaStar": sky.ThetaStar(),
    "Cheapest": sky.Cheapest(),
    "Cheapest, 12 million legs": sky.Cheapest(legs=12_000_000),
    "MFO, 10,000 evaluations": sky.MFO(legs="straight", waypoints=3),
    "LSHADE, 10,000 evaluations": sky.LSHADE(legs="straight"),
}
LATTICE = {
    "AStar": sky.AStar(),
    "HybridMVO, 10,000 evaluations": sky.HybridMVO(),
    "MVO, 10,000 evaluations": sky.MVO(),
    "RandomRestart, 10,000 evaluations": sky.RandomRestart(),
}


def builtins(count: int, seed: int) -> Iterator[sky.Problem]:
    """Yield every UAV's problem of every built-in scenario, to the target that it is assigned."""
    del count, seed
    for name in BUILTIN_NAMES:
        airspace = sky.Airspace(sky.read(name))
        for uav, target in enumerate(assign_targets(airspace)):
            if target is not None:
                yield sky.Problem(airspace, uav, target)


def threats(count: int, seed: int) -> Iterator[sky.Problem]:
    """Yield fields of 15 and of 30 threats, by turns."""
    for k in range(count):
        yield sky.Problem(sky.random_threats((15, 30)[k % 2], seed=seed + k))


def downtown(count: int, seed: int) -> Iterator[sky.Problem]:
    """Yield ways through downtowns of 300 buildings."""
    for k in range(count):
        yield sky.Problem(sky.random_downtown(300, seed=seed + k))


def terrain(count: int, seed: int) -> Iterator[sky.Problem]:
    """Yield flights over Jacksboro's ridges between random places 35 to 115 m above the ground."""
    scenario = sky.read("jacksboro")
    assert scenario.terrain is not None
    low, high = np.array(scenario.bounds.min) + 100.0, np.array(scenario.bounds.max) - 100.0
    for k in range(count):
        rng = np.random.default_rng(seed + k)
        ends = rng.uniform(low[:2], high[:2], (2, 2)).round(1)
        heights = (scenario.terrain.height(ends) + rng.uniform(35.0, 115.0, 2)).round(1)
        start, target = (tuple(place) for place in np.column_stack([ends, heights]).tolist())
        uav = scenario.uavs[0].model_copy(update={"start": start})
        yield sky.Problem(scenario.model_copy(update={"uavs": (uav,), "targets": (sky.Target(position=target),)}))


def shapes(count: int, seed: int) -> Iterator[sky.Problem]:
    """Yield ways among 100 to 800 cylinders, spheres and prisms on 100 m by 100 m, on a lattice of 0.5 m."""
    start, target = np.array([2.0, 2.0, 5.0]), np.array([98.0, 98.0, 12.0])
    for k in range(count):
        rng = np.random.default_rng(seed + k)
        found: list[sky.Cylinder | sky.Sphere | sky.Prism] = []
        for _ in range(rng.integers(100, 801)):
            centre, radius = rng.uniform((0, 0, 0), (100, 100, 20)), float(rng.uniform(0.5, 4.0))
            if min(np.linalg.norm((centre - end)[:2]) for end in (start, target)) < radius + 1.0:
                continue
            x, y, z = centre.tolist()
            angles = np.sort(rng.uniform(0.0, 2.0 * np.pi, 6))
            corners = [(x + radius * np.cos(angle), y + radius * np.sin(angle)) for angle in angles.tolist()]
            low, high = sorted(rng.uniform(-5.0, 25.0, 2).tolist())
            kind = rng.integers(3)
            if kind == 0:
                found.append(sky.Sphere(centre=(x, y, z), radius=radius))
            elif kind == 1 or np.max(np.diff(angles, append=angles[0] + 2.0 * np.pi)) > 3.0:
                found.append(sky.Cylinder(centre=(x, y), radius=radius, low=low, high=high))
            else:
                found.append(sky.Prism(vertices=tuple(corners), low=low, high=high))
        yield sky.Problem(
            sky.Scenario(
                name=f"shapes-{seed + k}",
                bounds=sky.Bounds(min=(0, 0, 0), max=(100, 100, 20)),
                obstacles=tuple(found),
                clearance=0.25,
                lattice=sky.Lattice(step=(0.5, 0.5, 0.5), connectivity=26),
                objective=sky.Objective(unit="metres"),
                uavs=(sky.UAV(start=tuple(start.tolist())),),
                targets=(sky.Target(position=tuple(target.tolist())),),
            )
        )


FIELDS = {"builtins": builtins, "threats": threats, "downtown": downtown, "terrain": terrain, "shapes": shapes}


def run(planner: sky.Planner, problem: sky.Problem) -> sky.Result:
    """Plan, and have the referee judge what is found."""
    result = planner.plan(problem, stop=BUDGET, rng=1)
    wrong = sky.check_result(problem.scenario, problem.uav, problem.target, result)
    assert not wrong, wrong
    return result


def contest(problems: Iterator[sky.Problem]) -> None:
    """Print the table of a field."""
    ratios, seconds = defaultdict(list), defaultdict(list)
    unreached = 0
    for problem in problems:
        default = sky.Auto()
        peers = STRAIGHT if default.leaves_lattice(problem.scenario) else LATTICE
        found = {name: run(planner, problem) for name, planner in {"Auto": default, **peers}.items()}
        if not any(result.status.reached for result in found.values()):
            unreached += 1
            continue
        least = min(result.cost for result in found.values() if result.status.reached)
        for name, result in found.items():  # the bound of one planner is no larger than the cost that another one finds
            assert result.bound is None or result.bound <= least * (1 + ROUNDING), (name, result.bound, least)
        for name, result in found.items():
            ratios[name].append(result.cost / least if result.status.reached else np.inf)
            seconds[name].append(result.seconds)
        if ratios["Auto"][-1] > 1 + NEAR:
            best = min(found, key=lambda name: found[name].cost if found[name].status.reached else np.inf)
            print(
                f"{problem.scenario.name}, {problem.scenario.uavs[0].start}: {ratios['Auto'][-1] - 1:.2%} above {best}"
            )
    rows = []
    for name, all_ratios in ratios.items():
        near = sum(ratio <= 1 + NEAR for ratio in all_ratios)
        rows.append(
            [
                name,
                f"{statistics.median(all_ratios) - 1:.3%}",
                f"{max(all_ratios) - 1:.2%}",
                f"{near} of {len(all_ratios)}",
                f"{statistics.median(seconds[name]):.3f} s",
                f"{max(seconds[name]):.2f} s",
            ]
        )
    table(["planner", "above the best: median", "worst", "within 0.5 %", "median time", "longest time"], rows)
    if unreached:
        print(f"In {unreached} problems more no planner finds a path.\n")


def main() -> None:
    """Run the contest on the fields asked for."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("fields", nargs="*", choices=[[], *FIELDS], default=[])
    parser.add_argument("--count", type=int, default=200, help="problems of each random field; 200 by default")
    parser.add_argument("--seeds", type=int, default=31_000, metavar="FROM", help="the first seed; 31000 by default")
    given = parser.parse_args()
    print(f"{describe()}\n")
    for field in given.fields or FIELDS:
        print(f"{field}, from seed {given.seeds}\n", flush=True)
        contest(FIELDS[field](given.count, given.seeds))


if __name__ == "__main__":
    main()
