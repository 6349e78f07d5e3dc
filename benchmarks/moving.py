"""Plans among random movers that are known beforehand: ``python benchmarks/moving.py [SCENARIO ...]``.

For each kind of movers the table tells how many of the missions the referee proves, how much later the last UAV arrives
than it would without movers, and how long planning takes, in seconds of processor time. ``--count``, ``--movers``,
``--speed`` and ``--seeds`` say how many missions of each kind, how many movers in each, how fast, as a share of the
UAVs' speed, and the first seed.

``--swaps`` plans fleets instead that exchange sides through tunnels 1 to 2 m wide, and through mazes: how many are
resolved and proven, how many times as late the last UAV arrives as on the longest flight alone, and how long it takes.
"""

import argparse
import statistics
import time
from typing import get_args

from machine import describe, table

import skyverse as sky
from skyverse.samples.movers import MoverKind


def missions(name: str, kind: MoverKind, given: argparse.Namespace) -> list[str]:
    """Plan missions among movers of one kind and return a row of the table."""
    scenario = sky.read(name)
    still = sky.plan_mission(scenario).makespan
    speed = given.speed * statistics.median(uav.max_speed for uav in scenario.uavs)
    later, seconds, proven = [], [], 0
    for seed in range(given.seeds, given.seeds + given.count):
        moving = sky.random_movers(scenario, given.movers, kind=kind, speed=speed, seed=seed)
        began = time.process_time()
        mission = sky.plan_mission(moving)
        seconds.append(time.process_time() - began)
        if not mission.violations:
            proven += 1
            later.append(mission.makespan / still - 1)
    shares = [f"{statistics.median(later):.1%}", f"{max(later):.1%}"] if later else ["", ""]
    times = [f"{statistics.median(seconds):.2f} s", f"{max(seconds):.2f} s"]
    return [name, kind, f"{proven} of {given.count}", *shares, *times]


WIDTHS = (1.0, 1.25, 1.5, 2.0)
"""Of tunnels, metres; one seed after another has the next one."""
FLEETS = ("tunnel", 10), ("tunnel", 20), ("tunnel", 40), ("tunnel", 60), ("maze", 20)


def swaps(kind: str, uavs: int, given: argparse.Namespace) -> list[str]:
    """Plan fleets that exchange sides and return a row of the table; the others are told with their pairs."""
    later, seconds, resolved = [], [], 0
    for seed in range(given.count):
        tunnel = kind == "tunnel"
        width = WIDTHS[seed % len(WIDTHS)]
        scenario = sky.tunnel_swap(uavs, width=width, seed=seed) if tunnel else sky.random_maze(uavs, seed=seed)
        began = time.process_time()
        mission = sky.plan_mission(scenario, assignment="identity")
        seconds.append(time.process_time() - began)
        done = mission.deconfliction
        if done is not None and not mission.violations:
            resolved += 1
            later.append(mission.makespan / done.makespan_before)
        elif done is not None:
            pairs = sorted({conflict.uavs for conflict in done.left})
            print(
                f"{scenario.name}: {len(mission.violations)} violations, conflicts are left between {pairs}", flush=True
            )
    shares = [f"{statistics.median(later):.1f}", f"{max(later):.1f}"] if later else ["", ""]
    times = [f"{statistics.median(seconds):.1f} s", f"{max(seconds):.1f} s"]
    return [kind, str(uavs), f"{resolved} of {given.count}", *shares, *times]


def main() -> None:
    """Plan among movers of each kind in the scenarios asked for."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("scenarios", nargs="*", default=["map1", "map2", "map3", "jacksboro"])
    parser.add_argument("--count", type=int, default=20, help="missions of each kind; 20 by default")
    parser.add_argument("--movers", type=int, default=50, help="movers in each; 50 by default")
    parser.add_argument("--speed", type=float, default=0.2, help="of movers, as a share of the UAVs'; 0.2 by default")
    parser.add_argument("--seeds", type=int, default=41_000, metavar="FROM", help="the first seed; 41000 by default")
    parser.add_argument("--swaps", action="store_true", help="plan fleets that exchange sides, without movers")
    given = parser.parse_args()
    print(f"{describe()}\n")
    if given.swaps:
        rows = [swaps(*fleet, given) for fleet in FLEETS]
        table(["fleet", "UAVs", "proven", "times as late: median", "at most", "planning: median", "at most"], rows)
        return
    rows = [missions(name, kind, given) for name in given.scenarios for kind in get_args(MoverKind)]
    table(["scenario", "movers", "proven", "later: median", "at most", "planning: median", "at most"], rows)


if __name__ == "__main__":
    main()
