"""Certificates among movers and zones with active times: ``python benchmarks/moving_certificates.py [WORLDS]``.

Random moving worlds (`moving_worlds`) are judged by the referee, and by dense sampling (`moving_oracle`), which shares
no code with it: 20,000 instants of each flight, and finer ones about the worst. What is proven must be clear at all of
them, also where the UAV strays by its tracking error; what is refuted must be too near at the instant that is named;
and what samples find too near must be refuted. The first disagreement ends the run with exit code 1 and names the
seed. ``--first`` says the first seed.
"""

import argparse
import sys
import time
from collections import Counter

import numpy as np
from machine import describe, table
from moving_oracle import excess, worst
from moving_worlds import moving_world

import skyverse as sky
from skyverse.referee import judge

LET_PASS = 1e-6  # metres, and shares of a limit
ROUNDING = 1e-8  # of the oracle; of speeds, which it takes from positions, 1e-4
FAULTS = {sky.Fault.MOVER: "mover", sky.Fault.ACTIVE_ZONE: "zone", sky.Fault.ZONE_SPEED: "limit"}
STRAYS = ((0, 0, 0), (1, 0, 1), (-0.6, 0.8, -1), (-0.6, -0.8, 0))


def compared(seed: int, counted: Counter) -> list[str]:
    """Judge one world by both, and return where they disagree."""
    mission = moving_world(seed)
    scenario, wrong = mission.scenario, []
    violations, (certificates, _) = judge(scenario, mission)
    end = max((flown.end for flown in mission.trajectories if flown is not None), default=0.0) + 1.0
    for uav, (flown, certificate) in enumerate(zip(mission.trajectories, certificates, strict=True)):
        if flown is None:
            counted["without a path"] += 1
            continue
        own = [one for one in violations if one.uavs == (uav,)]
        counted[certificate.verdict.value] += 1
        error = scenario.uavs[uav].tracking_error
        exact = error == sky.TrackingError()
        reach = np.array([error.horizontal, error.horizontal, error.vertical])
        undecided = any(one.fault is sky.Fault.UNDECIDED for one in own)
        named = {FAULTS[one.fault] for one in own if one.fault in FAULTS}
        for aside in STRAYS[:1] if exact else STRAYS:
            for (kind, number), (depth, at) in worst(scenario, flown, end, reach * aside).items():
                slack = 1e-4 if kind == "limit" else LET_PASS + ROUNDING
                if depth > slack and kind not in named and not undecided:
                    wrong.append(f"UAV {uav} is {depth:.3g} too deep in {kind} {number} at {at:.9g} s, unnoticed")
        for one in own:
            if one.fault not in FAULTS:
                continue
            counted[one.fault.value] += 1
            if exact:
                around = np.array([one.time - 1e-9, one.time, one.time + 1e-9])
                depths = excess(scenario, flown, around, np.zeros(3))
                there = max(depth.max() for (kind, _), depth in depths.items() if kind == FAULTS[one.fault])
                if not there > (-1e-4 if one.fault is sky.Fault.ZONE_SPEED else 0):
                    wrong.append(f"{one.message} But the excess there is {there:.3g}.")
    return [f"seed {seed}: {complaint}" for complaint in wrong]


def main() -> None:
    """Compare as many worlds as asked for, and print what was counted."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("worlds", type=int, nargs="?", default=10_000, help="how many; 10000 by default")
    parser.add_argument("--first", type=int, default=0, metavar="SEED", help="the first seed; 0 by default")
    given = parser.parse_args()
    counted: Counter = Counter()
    began = time.process_time()
    for seed in range(given.first, given.first + given.worlds):
        wrong = compared(seed, counted)
        if wrong:
            sys.exit("\n".join(wrong))
        if (seed + 1) % 100 == 0:
            print(f"{seed + 1 - given.first:,} worlds: {dict(counted)}", file=sys.stderr, flush=True)
    print(f"{describe()}; {time.process_time() - began:.0f} s\n")
    table(["of the flights in", f"{given.worlds:,} worlds"], [[name, f"{n:,}"] for name, n in counted.most_common()])


if __name__ == "__main__":
    main()
