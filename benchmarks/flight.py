"""Every built-in mission flown in rotorpy, calm and with 1 m/s across: ``python benchmarks/flight.py [VEHICLE ...]``.

Missions are planned by Taut, seed 1. The wind blows across the longer side of the map. Largest and RMS are tracking
errors; clearance is the least distance to an obstacle as given, separation the least nearness of any two UAVs (1 is the
required separation), as flown and as planned. By default the thesis's vehicle flies. Missions that take longer than a
minute are left out. With ``--maps`` only the first three maps are flown. With ``--stock`` they are flown by rotorpy's
controller with nothing but the trajectory: the difference shows the effect of the feedforward.
"""

import sys
import time

import numpy as np
from machine import describe, table

import skyverse as sky
from skyverse.files import BUILTIN_NAMES
from skyverse.flight import WindObserver, commands
from skyverse.numerics.cores import cores

LONG_MISSION = 60.0
"""Seconds: longer missions are left out, as rotorpy flies only about seven times as fast as real time."""
HEAD = ("mission", "vehicle", "wind", "RMS", "largest", "clearance", "separation", "thrust", "energy", "verdict", "s")


def across(scenario: sky.Scenario) -> tuple[float, float, float]:
    """Return 1 m/s across the longer horizontal side of the bounds."""
    east, north, _ = np.subtract(scenario.bounds.max, scenario.bounds.min)
    return (1.0, 0.0, 0.0) if north > east else (0.0, 1.0, 0.0)


def row(name: str, vehicle: str, wind: str, flight: sky.Flight, seconds: float) -> list[str]:
    flown = [f for f in flight.flown if f is not None]
    rms = np.sqrt(sum(f.rms**2 * len(f.times) for f in flown) / sum(len(f.times) for f in flown))
    closest = min(flight.passings, key=lambda passing: passing.nearness, default=None)
    return [
        name,
        vehicle,
        wind,
        f"{1000 * rms:.1f} mm",
        f"{1000 * flight.largest:.1f} mm",
        f"{min(f.clearance for f in flown):.3f} m",
        "" if closest is None else f"{closest.nearness:.2f} ({closest.planned:.2f})",
        f"{max(f.peak_thrust for f in flown):.0%}",
        f"{sum(f.energy for f in flown):.0f} J",
        "safe" if flight.safe else "; ".join(sorted({v.fault.value for v in flight.violations})),
        f"{seconds:.0f}",
    ]


def main() -> None:
    words = sys.argv[1:]
    stock = "--stock" in words
    few = stock or "--maps" in words
    vehicles = [word for word in words if not word.startswith("--")] or ["thesis"]
    if stock:
        commands.reference = lambda trajectory, kind, times, hold: trajectory.at(times)
        WindObserver.push = lambda *_: 0.0
    print(describe("rotorpy"))
    print()
    rows = []
    for name in BUILTIN_NAMES[:3] if few else BUILTIN_NAMES:
        scenario = sky.read_scenario(name)
        mission = sky.plan_mission(scenario, sky.Taut(), rng=1)
        if mission.makespan > LONG_MISSION:
            continue
        for vehicle in vehicles:
            for wind, speed in (("calm", (0.0, 0.0, 0.0)), ("1 m/s", across(scenario))):
                began = time.perf_counter()
                flight = sky.fly(
                    mission, sky.Conditions(vehicle=vehicle, wind=speed), rng=1, workers=1 if stock else cores()
                )
                rows.append(row(name, vehicle, wind, flight, time.perf_counter() - began))
                print(*rows[-1], sep=" | ", file=sys.stderr)
    table(HEAD, rows)


if __name__ == "__main__":
    main()
