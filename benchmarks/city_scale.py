"""Judging and exporting at city scale: ``python benchmarks/city_scale.py`` prints a table of docs/performance.md.

The city has 34,000 prisms: blocks of 100 m with twelve buildings each, which are L-shaped, octagonal or have
courtyards, between streets of 16 m. Every UAV flies along streets, below most roofs, around several corners. It is
measured how long the referee takes to judge the mission, and how long an export to ``.plan`` takes, which places
waypoints and has them proven. Numbers on the command line are the UAVs of each fleet (20 and 100).
"""

import sys
import tempfile
import time
from itertools import pairwise
from pathlib import Path

import numpy as np
from machine import describe, table

import skyverse as sky
from skyverse.exports import ExportCertificate
from skyverse.planners.base import provenance
from skyverse.planners.results import SearchRecord, any_angle_result
from skyverse.problem import Airspace, Problem
from skyverse.trajectory import fly_along

PRISMS = 34_000
BLOCK, STREET, PLOTS = 100.0, 16.0, 12
HEIGHT = 25.0
"""Metres above ground at which the first UAV flies; the others fly a little higher, each at a height of its own."""


def footprint(rng: np.random.Generator, west: float, south: float, wide: float, deep: float) -> sky.Prism:
    """Return a building on a plot: an L, a cut-off rectangle, or a rectangle around a courtyard."""
    u, v = rng.uniform(0.3, 0.6, 2)
    outlines = (
        [(0, 0), (1, 0), (1, v), (u, v), (u, 1), (0, 1)],
        [(0.2, 0), (0.8, 0), (1, 0.2), (1, 0.8), (0.8, 1), (0.2, 1), (0, 0.8), (0, 0.2)],
        [(0, 0), (1, 0), (1, 1), (0, 1)],
    )
    which = int(rng.integers(3))
    size, corner = np.array([wide, deep]), np.array([west, south])
    vertices = tuple(map(tuple, np.round(corner + size * outlines[which], 3).tolist()))
    court = np.array([(0.35, 0.35), (0.65, 0.35), (0.65, 0.65), (0.35, 0.65)])
    holes = (tuple(map(tuple, np.round(corner + size * court, 3).tolist())),) if which == 2 else ()
    return sky.Prism(
        vertices=vertices, holes=holes, low=0.0, high=round(float(rng.uniform(15, 60)), 2), kind="building"
    )


def city(prisms: int, uavs: int) -> sky.Scenario:
    """Return the city and its UAVs, each of which starts and ends at a crossing."""
    rng = np.random.default_rng(1)
    blocks = int(np.ceil(np.sqrt(prisms / PLOTS)))
    buildings = []
    for k in range(prisms):
        block, plot = divmod(k, PLOTS)
        i, j = divmod(block, blocks)
        a, b = divmod(plot, 3)
        wide, deep = (BLOCK - STREET) / 4, (BLOCK - STREET) / 3
        west, south = i * BLOCK + STREET / 2 + a * wide, j * BLOCK + STREET / 2 + b * deep
        buildings.append(footprint(rng, west + 0.5, south + 0.5, wide - 1, deep - 1))
    side = blocks * BLOCK
    ends = []
    for k in range(uavs):
        crossing = rng.integers(1, blocks - 1, 2)
        away = np.clip(crossing + rng.integers(3, 9, 2) * rng.choice([-1, 1], 2), 0, blocks)
        z = HEIGHT + 0.3 * k
        ends.append([(*(place * BLOCK).tolist(), z) for place in (crossing, away)])
    return sky.Scenario(
        name=f"{prisms} prisms",
        bounds=sky.Bounds(min=(-STREET, -STREET, 0), max=(side + STREET, side + STREET, 120)),
        obstacles=buildings,
        clearance=2.0,
        lattice=sky.Lattice(step=(10, 10, 10), connectivity=26),
        objective=sky.Objective(unit="metres"),
        uavs=[sky.UAV(start=start, max_speed=12, max_acceleration=4) for start, _ in ends],
        targets=[sky.Target(position=end) for _, end in ends],
        frame=sky.Frame(origin=sky.Origin(latitude=40.7, longitude=-74.0, altitude=5.0)),
    )


def streets(start: np.ndarray, end: np.ndarray) -> np.ndarray:
    """Return a way along streets with a corner at every second crossing, (n, 3) metres."""
    here, way, turn = start.copy(), [start], 0
    while np.any(here[:2] != end[:2]):
        axis = turn % 2 if here[turn % 2] != end[turn % 2] else 1 - turn % 2
        here = here.copy()
        left = end[axis] - here[axis]
        here[axis] += np.sign(left) * min(abs(left), 2 * BLOCK)
        way.append(here)
        turn += 1
    return np.array(way)


def fleet(scenario: sky.Scenario) -> sky.Mission:
    """Return the mission of the UAVs along streets, as a planner's path would be flown."""
    airspace = Airspace(scenario)
    results, flights = [], []
    for uav in range(len(scenario.uavs)):
        problem = Problem(airspace, uav, uav)
        record = SearchRecord(provenance("streets", None, None))
        results.append(any_angle_result(problem, streets(problem.start, problem.end), None, record))
        flights.append(fly_along(problem, results[-1]))
    assignment = tuple(range(len(results)))
    return sky.Mission(scenario, assignment, tuple(results), tuple(flights), (), provenance("streets", None, None))


def measured(uavs: int) -> list[str]:
    """Return a fleet's row of the table; seconds are those of the clock, and in brackets those of the processor."""
    mission = fleet(city(PRISMS, uavs))
    seen: list[ExportCertificate] = []
    with tempfile.TemporaryDirectory() as folder:
        clocks = [(time.perf_counter(), time.process_time())]
        violations = sky.check(mission.scenario, mission)
        clocks.append((time.perf_counter(), time.process_time()))
        files = sky.export(
            mission, Path(folder) / "city.plan", sky.ExportOptions(allow_close=True), on_certificate=seen.append
        )
        clocks.append((time.perf_counter(), time.process_time()))
    assert not [v for v in violations if v.fault.value.endswith("too close") and len(v.uavs) == 1]
    (certificate,) = seen
    waypoints = sum(len(back.plan.waypoints) for back in certificate.returns)
    seconds = [[end - start for start, end in zip(*pair, strict=True)] for pair in pairwise(clocks)]
    taken = [f"{wall:.1f} ({processor:.1f})" for wall, processor in seconds]
    return [str(uavs), *taken, f"{len(files)} files, {waypoints} waypoints"]


def main() -> None:
    """Print the table."""
    print(f"{describe()}\n")
    small = fleet(city(240, 2))  # compiles
    sky.check(small.scenario, small)
    with tempfile.TemporaryDirectory() as folder:
        sky.export(small, Path(folder) / "city.plan", sky.ExportOptions(allow_close=True))
    rows = [measured(int(count)) for count in sys.argv[1:] or ("20", "100")]
    table([f"UAVs among {PRISMS:,} prisms", "check, s", ".plan, s", "exported"], rows)


if __name__ == "__main__":
    main()
