"""Deconfliction of fleets: ``python benchmarks/deconfliction.py`` prints the tables of docs/missions.md.

The fleets are those of the thesis (Tables 4.8 to 4.13), circles of 8, 32 and 128 UAVs that change places, and 100 UAVs
that change places through the window of Map 1. Then it is measured how long it takes to find all conflicts of 1,000
flights. Violations are those that the referee finds. The lower bound of the makespan is the longest single flight.
Names on the command line (``table-4.8 circle-32 window-100 flights``) select some of them.
"""

import sys
import time
from collections import Counter

import numpy as np
from machine import describe, table

import skyverse as sky
from skyverse.trajectory import rest_to_rest

FLEETS = ("table-4.8", "table-4.9-2", "table-4.9-3", "table-4.9-4", "table-4.11", "table-4.12", "table-4.13")
SWAPS = ("circle-8", "circle-32", "circle-128", "window-100")


def scenario(name: str) -> sky.Scenario:
    """Return the fleet of a name."""
    kind, _, uavs = name.partition("-")
    if kind == "circle":
        return sky.circle_swap(int(uavs))
    if kind == "window":
        return sky.window_swap(sky.read_scenario("map1"), int(uavs))
    return sky.read_scenario(name)


def deconflicted(name: str) -> list[str]:
    """Return a fleet's row of the table: what was found, done and left, and the seconds that it took."""
    given = scenario(name)
    assignment = "identity" if name in SWAPS else "path-cost"
    began = time.perf_counter()
    alone = sky.plan_mission(
        given, sky.Taut(), rng=1, assignment=assignment, options=sky.MissionOptions(keep_apart=False)
    )
    planned = time.perf_counter()
    mission = sky.plan_mission(given, sky.Taut(), rng=1, assignment=assignment)
    ended = time.perf_counter()
    done = mission.deconfliction
    assert done is not None
    assert mission.apart is not None
    wrong = Counter(violation.fault.value for violation in mission.violations)
    actions = Counter(action.kind for action in done.actions)
    return [
        name,
        str(len(done.found)),
        ", ".join(f"{count} {fault}" for fault, count in wrong.items()) or "none",
        mission.apart.verdict.value,
        f"{done.total_before:.1f}, {done.total_after:.1f}",
        f"{done.makespan_before:.2f}, {done.makespan_after:.2f}",
        f"{done.makespan_after / alone.makespan - 1:.1%}",
        ", ".join(f"{count} {kind}" for kind, count in sorted(actions.items())) or "none",
        f"{(ended - planned) - (planned - began):.1f}",
    ]


def flights(count: int, side: float, height: float) -> tuple[sky.Scenario, list[sky.Trajectory]]:
    """Return flights between random points, each by way of a third one, that depart within five seconds."""
    rng = np.random.default_rng(1)
    places = rng.uniform(0, [side, side, height], (count, 3, 3))
    uavs = [sky.UAV(start=tuple(way[0])) for way in places]
    given = sky.Scenario(
        name="flights",
        bounds=sky.Bounds(min=(0, 0, 0), max=(side, side, height)),
        clearance=0,
        lattice=sky.Lattice(step=(5, 5, 5)),
        uavs=uavs,
    )
    return given, [rest_to_rest(way, uav, rng.uniform(0, 5)) for way, uav in zip(places, uavs, strict=True)]


def main() -> None:
    """Print the tables."""
    asked = sys.argv[1:] or [*FLEETS, *SWAPS, "flights"]
    print(f"{describe()}\n")
    deconflicted("table-4.8")  # compiles
    deconflicted("table-4.13")
    head = ["fleet", "conflicts", "violations", "apart", "total, s", "makespan, s", "over the bound", "done", "seconds"]
    rows = []
    for name in asked:
        if name != "flights":
            rows.append(deconflicted(name))
            print(" | ".join(rows[-1]), flush=True)
    if rows:
        print()
        table(head, rows)
    if "flights" in asked:
        lines = []
        for count, side in ((1000, 300.0), (1000, 60.0)):
            given, flown = flights(count, side, 60.0)
            began = time.perf_counter()
            found = sky.find_conflicts(given, flown)
            seconds = time.perf_counter() - began
            lines.append([f"{count:,} in {side:g} x {side:g} x 60 m", str(len(found)), f"{seconds:.2f}"])
        table(["flights", "conflicts", "seconds"], lines)


if __name__ == "__main__":
    main()
