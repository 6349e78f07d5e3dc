"""Seconds by phase, and memory, of surveys of 1 and 10 km2 at 2 cm over a ground grid of 1 m, with zones and UAVs."""

import math
import os
import resource
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager

import numpy as np
from machine import table

import skyverse as sky
from skyverse.mission import plan_mission as planning


def hills(side: float, uavs: int = 3) -> sky.Scenario:
    """Return a survey of a square of hills, with a zone for each km2."""
    low, high = -100.0, side + 100.0
    x, y = np.meshgrid(*[np.arange(low, high + 1.0)] * 2, indexing="ij")
    heights = 30.0 * np.sin(x / 130.0) + 20.0 * np.cos(y / 90.0) + 3.0 * np.sin(x / 17.0) * np.sin(y / 23.0)
    start = float(heights[50, 50]) + 20.0
    fleet = tuple(
        sky.UAV(
            name=f"d{i}",
            start=(low + 30.0 + 15.0 * i, low + 30.0, start),
            end="home",
            max_speed=15.0,
            max_acceleration=3.0,
            max_climb=5.0,
            max_descent=4.0,
            separation=5.0,
        )
        for i in range(uavs)
    )
    zones = tuple(
        sky.Cylinder(
            centre=(500.0 + 1000.0 * i, 500.0 + 1000.0 * j),
            radius=60.0,
            low=-60.0,
            high=250.0,
            name=f"z{i}{j}",
            kind="no-fly zone",
            solid=False,
        )
        for i in range(max(round(side / 1000.0), 1))
        for j in range(max(round(side / 1000.0), 1))
    )
    return sky.Scenario(
        name="hills",
        bounds={"min": (low, low, -60.0), "max": (high, high, 250.0)},
        clearance=5.0,
        terrain={"origin": (low, low), "step": (1.0, 1.0), "heights": heights},
        uavs=fleet,
        obstacles=zones,
        surveys=(sky.Survey([(0, 0), (side, 0), (side, side), (0, side)], "mavic-3e", gsd="2 cm"),),
    )


@contextmanager
def timed(home: object, name: str, spent: dict[str, float]) -> Iterator[None]:
    """Add up the seconds that a function takes while the block runs."""
    function: Callable = getattr(home, name)

    def measured(*given: object, **named: object) -> object:
        begun = time.perf_counter()
        try:
            return function(*given, **named)
        finally:
            spent[name] = spent.get(name, 0.0) + time.perf_counter() - begun

    setattr(home, name, measured)
    try:
        yield
    finally:
        setattr(home, name, function)


def scale(*sides: int) -> None:
    """Plan and prove surveys of squares so many metres wide, 1,000 and 3,162 if nothing is said."""
    sky.plan_mission(hills(200.0), rng=1)  # compiled
    rows = []
    for side in sides or (1000, 3162):
        given, spent = hills(float(side)), {}
        begun = time.perf_counter()
        with (
            timed(planning, "survey_flights", spent),
            timed(planning, "plan_tours", spent),
            timed(planning, "judged", spent),
        ):
            mission = sky.plan_mission(given, rng=1)
        whole = time.perf_counter() - begun
        verdicts = ", ".join(one.verdict.value for one in mission.coverage)
        proven, lines = spent.get("judged", math.nan), spent.get("survey_flights", math.nan)
        memory = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 2**20
        rows.append(
            [
                f"{side:,}",
                *(f"{one:.1f}" for one in (lines, spent.get("plan_tours", math.nan), proven, whole)),
                f"{memory:.2f}",
                verdicts,
            ]
        )
    table(["side m", "strips s", "routes and flights s", "proven s", "all s", "peak GB", "coverage"], rows)
    print(f"Other work on this machine: load {os.getloadavg()[0]:.1f} on {os.cpu_count()} cores.")
