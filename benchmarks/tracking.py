"""Every built-in mission flown many times in gusts: ``python benchmarks/tracking.py [MISSION ...]``.

Missions are planned by Taut, seed 1, and flown by the thesis's vehicle until no run touches anything, or the mission is
refused as too tight, in a mean wind of 8 m/s from west with Dryden gusts and a mismatch of 20 %: 1,000 runs of the
short missions and 30 of those that take longer than a minute. ``--wind-speed``, ``--wind-from``, ``--runs`` and
``--vehicle`` change that. Errors are medians, 99 % and largest of all UAVs; clearance and separation are the smallest
of all runs.
"""

import argparse
import sys
import time

from machine import describe, table

import skyverse as sky
from skyverse.files import BUILTIN_NAMES

HEAD = ("mission", "runs", "speed", "horizontal error", "vertical error", "clearance", "separation", "verdict", "s")
LONG_MISSION = 60.0
"""Seconds: longer missions are flown 30 times only."""


def of_all(errors: sky.Distribution) -> str:
    return ", ".join(f"{metres:.3f}" for metres in (errors.median, errors.percentile_99, errors.largest)) + " m"


def row(name: str, flown: sky.FlightRuns, planned: float, seconds: float) -> list[str]:
    safe = "safe" if flown.safe else flown.refusal
    return [
        name,
        str(flown.runs),
        f"{planned / flown.mission.makespan:.0%}",
        of_all(flown.all_errors.horizontal),
        of_all(flown.all_errors.vertical),
        f"{flown.clearance.min():.2f} m",
        f"{flown.separation.min():.2f} m" if flown.separation.min() < float("inf") else "",
        safe + (f"; {len(flown.rounds)} rounds" if flown.rounds else ""),
        f"{seconds:.0f}",
    ]


def main() -> None:
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("missions", nargs="*", default=BUILTIN_NAMES, help="built-in names; all by default")
    parser.add_argument("--wind-speed", type=float, default=8.0)
    parser.add_argument("--wind-from", type=float, default=270.0)
    parser.add_argument("--runs", type=int, help="1,000 by default, and 30 of long missions")
    parser.add_argument("--vehicle", default="thesis")
    options = parser.parse_args()
    print(describe())
    print()
    rows = []
    for name in options.missions:
        mission = sky.plan_mission(sky.read_scenario(name), sky.Taut(), rng=1)
        runs = options.runs or (30 if mission.makespan > LONG_MISSION else 1000)
        began = time.perf_counter()
        flown = sky.fly_until_safe(
            mission,
            sky.Conditions(
                vehicle=options.vehicle,
                wind=sky.wind_from(options.wind_speed, options.wind_from),
                gusts=True,
                mismatch=0.2,
            ),
            runs=runs,
            rng=1,
        )
        rows.append(row(name, flown, mission.makespan, time.perf_counter() - began))
        print(*rows[-1], sep=" | ", file=sys.stderr, flush=True)
    table(HEAD, rows)


if __name__ == "__main__":
    main()
