"""Flights that are replanned among random movers that are not known beforehand: ``python benchmarks/replanning.py``.

For each kind of movers the table tells how many flights arrive, how many the referee proves clear of the movers as they
were, the least distance beyond the clearance that is kept, how much longer flights take than the same replanner takes
without movers, and the milliseconds of one replan: median, 99 % and worst. ``--count``, ``--movers``, ``--speed``,
``--seeds``, ``--rate`` and ``--reach`` say how many flights of each kind, how many movers in each, how fast they are in
m/s, the first seed, how often a second movers are seen, and within how many metres.
"""

import argparse
import statistics
from dataclasses import replace
from typing import get_args

import numpy as np
from machine import describe, table

import skyverse as sky
from skyverse.samples.movers import MoverKind
from skyverse.space.moving_shapes import mover_gaps, moving_shapes
from skyverse.space.timed_shapes import timed_shapes

LONGEST = 60.0
"""Seconds after which a flight that has not arrived is counted as one that does not."""
TURNS_AT_ONCE = ("patrols", "traffic")
"""Movers that turn back in an instant, so that nothing is known of their acceleration."""


def bounds(movers: tuple[sky.Mover, ...]) -> tuple[float, float]:
    """Return the largest speed and acceleration of movers, from samples, with a margin."""
    t = np.linspace(0.0, LONGEST, 30_001)
    fastest = hardest = 0.0
    for mover in movers:
        velocity = np.gradient(mover.at(t), t, axis=0)
        fastest = max(fastest, float(np.linalg.norm(velocity, axis=1).max()))
        hardest = max(hardest, float(np.linalg.norm(np.gradient(velocity, t, axis=0)[2:-2], axis=1).max()))
    return 1.01 * fastest, 1.01 * hardest


def fly(mission: sky.Mission, movers: tuple[sky.Mover, ...], hard: bool, given: argparse.Namespace) -> sky.Replanner:
    """Fly until all UAVs have arrived, or for the longest time; the answers are kept in `given`."""
    replanner, uavs = sky.Replanner(mission), range(len(mission.scenario.uavs))
    top, hardest = bounds(movers)
    for k in range(int(LONGEST * given.rate)):
        t = k / given.rate
        at = [replanner.motion(uav).at([t]).position[0] for uav in uavs]
        seen = [
            sky.Sighting(
                name=one.name,
                shape=one.shape,
                position=one.at([t])[0],
                top_speed=max(top, 1e-3),
                max_acceleration=hardest if hard else None,
            )
            for one in movers
            if min(np.linalg.norm(one.at([t])[0] - place) for place in at) <= given.reach
        ]
        given.answers.extend(replanner.observe(t, movers=seen))
        arrivals = [replanner.arrival(uav) for uav in uavs]
        if all(arrival is not None and arrival <= t for arrival in arrivals):
            break
    return replanner


def flights(name: str, kind: MoverKind, given: argparse.Namespace) -> list[str]:
    """Fly among movers of one kind and return a row of the table."""
    scenario = sky.read(name)
    mission, uavs = sky.plan_mission(scenario), range(len(scenario.uavs))
    given.answers = []
    still = fly(mission, (), True, given)
    alone = max(still.arrival(uav) or LONGEST for uav in uavs)
    given.answers = []
    arrived, proven, longer, least = 0, 0, [], np.inf
    for seed in range(given.seeds, given.seeds + given.count):
        moving = sky.random_movers(scenario, given.movers, kind=kind, speed=given.speed, seed=seed)
        replanner = fly(mission, moving.movers, kind not in TURNS_AT_ONCE, given)
        flown = tuple(replanner.flown(uav) for uav in uavs)
        ends = [replanner.arrival(uav) for uav in uavs]
        certificates = sky.certify(moving, replace(mission, scenario=moving, trajectories=flown))
        if None not in ends:
            arrived += 1
            longer.append(max(ends) / alone - 1)
            verdicts = [one.verdict for one in (*certificates.trajectories, certificates.apart)]
            proven += all(verdict is sky.Verdict.PROVEN for verdict in verdicts)
        for uav, flight in zip(scenario.uavs, flown, strict=True):
            t = np.arange(0.0, flight.end, 0.01)
            shapes = moving_shapes(timed_shapes(moving), uav.tracking_error)
            least = min(least, float(mover_gaps(shapes, t, flight.at(t).position).min(initial=np.inf)))
    milliseconds = [1e3 * answer.seconds for answer in given.answers]
    unproven = sum(not answer.proven for answer in given.answers)
    return [
        name,
        kind,
        f"{arrived} of {given.count}",
        f"{proven} of {arrived}",
        f"{unproven} of {len(given.answers)}",
        f"{least:.2f} m",
        f"{statistics.median(longer):.0%}" if longer else "",
        *(f"{value:.1f} ms" for value in np.percentile(milliseconds, [50, 99, 100])),
    ]


def main() -> None:
    """Fly among movers of each kind in the scenarios asked for."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("scenarios", nargs="*", default=["map1", "map2", "map3"])
    parser.add_argument("--count", type=int, default=10, help="flights of each kind; 10 by default")
    parser.add_argument("--movers", type=int, default=10, help="movers in each; 10 by default")
    parser.add_argument("--speed", type=float, default=0.5, help="their mean speed, m/s; 0.5 by default")
    parser.add_argument("--seeds", type=int, default=51_000, metavar="FROM", help="the first seed; 51000 by default")
    parser.add_argument("--rate", type=float, default=10.0, help="observations a second; 10 by default")
    parser.add_argument("--reach", type=float, default=8.0, help="metres in which movers are seen; 8 by default")
    given = parser.parse_args()
    print(f"{describe()}\n")
    rows = [flights(name, kind, given) for name in given.scenarios for kind in get_args(MoverKind)]
    head = ["scenario", "movers", "arrived", "proven", "without way out", "least spare distance", "longer: median"]
    table([*head, "replan: median", "99 %", "worst"], rows)


if __name__ == "__main__":
    main()
