"""Plans among random movers that are known beforehand: ``python benchmarks/moving.py [SCENARIO ...]``.

For each kind of movers the table tells how many of the missions the referee proves, how much later the last UAV arrives
than it would without movers, and how long planning takes, in seconds of processor time. ``--count``, ``--movers``,
``--speed`` and ``--seeds`` say how many missions of each kind, how many movers in each, how fast, as a share of the
UAVs' speed, and the first seed.

``--swaps`` plans fleets instead that exchange sides through tunnels 1 to 2 m wide, and through mazes: how many are
resolved and proven, how many times as late the last UAV arrives as on the longest flight alone, and how long it takes.
``--spinners`` plans ten UAVs that exchange the sides of a forest or a maze among four spinners, which are as fast as
the UAVs, and twice as fast. ``--fleets`` says which of these fleets are planned.

``--mvo`` plans with MVO instead, with the price of contact in its cost and without it: how many missions are proven
whose UAVs depart at once, whatever they meet, and how many where they may also wait, fly slowly or take detours.
"""

import argparse
import statistics
import time
from dataclasses import dataclass
from typing import get_args

from machine import describe, table

import skyverse as sky
from skyverse.planners.contact import without_movers
from skyverse.planners.moves import LatticeTask
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


@dataclass(frozen=True, kw_only=True)
class TimelessMVO(sky.MVO):
    """MVO to which contact with movers costs nothing."""

    def task(self, problem: sky.Problem) -> LatticeTask:
        """Return what is sought."""
        task = super().task(problem)
        return task._replace(contact=without_movers(task.contact))


def metaheuristics(name: str, kind: MoverKind, given: argparse.Namespace) -> list[list[str]]:
    """Plan missions among movers of one kind by MVO, with a time axis in its cost and without; return both rows."""
    scenario, rows = sky.read(name), []
    speed = given.speed * statistics.median(uav.max_speed for uav in scenario.uavs)
    for planner in (sky.MVO(), TimelessMVO()):
        direct, proven, arrivals, seconds = 0, 0, [], []
        for seed in range(given.seeds, given.seeds + given.count):
            moving = sky.random_movers(scenario, given.movers, kind=kind, speed=speed, seed=seed)
            direct += not sky.plan_mission(
                moving, planner, rng=seed, options=sky.MissionOptions(keep_apart=False)
            ).violations
            began = time.process_time()
            mission = sky.plan_mission(moving, planner, rng=seed)
            seconds.append(time.process_time() - began)
            if not mission.violations:
                proven += 1
                arrivals.append(mission.makespan)
        times = [f"{statistics.mean(arrivals):.2f} s", f"{max(arrivals):.2f} s"] if arrivals else ["", ""]
        axis = "without" if isinstance(planner, TimelessMVO) else "with"
        shares = [f"{direct} of {given.count}", f"{proven} of {given.count}"]
        rows.append([name, kind, axis, *shares, *times, f"{statistics.median(seconds):.2f} s"])
        print("  ".join(rows[-1]), flush=True)
    return rows


WIDTHS = (1.0, 1.25, 1.5, 2.0)
"""Of tunnels, metres; one seed after another has the next one."""
SWAPS = ("tunnel-10", "tunnel-20", "tunnel-40", "tunnel-60", "maze-20")
SPINNERS = ("forest-10-1", "forest-10-2", "maze-10-1", "maze-10-2")
"""Fleets among spinners: how many UAVs, and how many times as fast as they the spinners are."""


def fleet(name: str, seed: int) -> sky.Scenario:
    """Return a fleet that exchanges sides: the kind, how many UAVs, and the speed of four spinners, if any."""
    kind, uavs, *speed = name.split("-")
    if kind == "tunnel":
        made = sky.tunnel_swap(int(uavs), width=WIDTHS[seed % len(WIDTHS)], seed=seed)
    else:
        made = (sky.forest_swap if kind == "forest" else sky.random_maze)(int(uavs), seed=seed)
    if not speed:
        return made
    fast = float(speed[0]) * made.uavs[0].max_speed
    return sky.random_movers(made, 4, kind="spinners", speed=fast, seed=seed)


def swaps(name: str, given: argparse.Namespace) -> list[str]:
    """Plan fleets that exchange sides and return a row of the table; the others are told with their pairs."""
    later, seconds, resolved = [], [], 0
    first = given.first
    for seed in range(first, first + given.count):
        scenario = fleet(name, seed)
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
    return [name, f"{resolved} of {given.count}", *shares, *times]


def main() -> None:
    """Plan among movers of each kind in the scenarios asked for."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("scenarios", nargs="*", default=["map1", "map2", "map3", "jacksboro"])
    parser.add_argument("--count", type=int, default=20, help="missions of each kind; 20 by default")
    parser.add_argument("--movers", type=int, default=50, help="movers in each; 50 by default")
    parser.add_argument("--speed", type=float, default=0.2, help="of movers, as a share of the UAVs'; 0.2 by default")
    parser.add_argument("--seeds", type=int, default=41_000, metavar="FROM", help="the first seed; 41000 by default")
    parser.add_argument("--swaps", action="store_true", help="plan fleets that exchange sides, without movers")
    parser.add_argument("--spinners", action="store_true", help="plan fleets that exchange sides among four spinners")
    parser.add_argument("--fleets", nargs="+", default=(), metavar="FLEET", help="such as tunnel-10 or forest-10-2")
    parser.add_argument("--first", type=int, default=0, metavar="SEED", help="of such fleets, the first; 0 by default")
    parser.add_argument("--mvo", action="store_true", help="plan with MVO, with and without the price of contact")
    given = parser.parse_args()
    print(f"{describe()}\n")
    fleets = [*given.fleets, *(SWAPS if given.swaps else ()), *(SPINNERS if given.spinners else ())]
    if fleets:
        rows = [swaps(name, given) for name in fleets]
        table(["fleet", "proven", "times as late: median", "at most", "planning: median", "at most"], rows)
        return
    if given.mvo:
        rows = [
            row for name in given.scenarios for kind in get_args(MoverKind) for row in metaheuristics(name, kind, given)
        ]
        heads = ["proven at once", "proven", "arrival: mean", "at most", "planning: median"]
        table(["scenario", "movers", "time axis", *heads], rows)
        return
    rows = [missions(name, kind, given) for name in given.scenarios for kind in get_args(MoverKind)]
    table(["scenario", "movers", "proven", "later: median", "at most", "planning: median", "at most"], rows)


if __name__ == "__main__":
    main()
