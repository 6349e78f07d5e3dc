"""Every planner in thousands of random rooms, judged independently: ``python benchmarks/rooms.py [ROOMS]``.

The referee judges every path that any planner returns. Where Taut says that no path exists, flooding a lattice of a
sixteenth of a metre (its nodes blocked anew here, labelled by scipy) must agree; where a planner on the scenario's
lattice does, flooding that one.
"""

import sys
import time
from collections import Counter
from multiprocessing import get_context

import numpy as np
from machine import describe, table
from scipy import ndimage

import skyverse as sky
from skyverse.numerics.cores import cores

PLANNERS = {
    "Taut": sky.Taut(),
    "Theta*": sky.ThetaStar(),
    "A*": sky.AStar(),
    "HybridMVO": sky.HybridMVO(universes=6),
    "MVO": sky.MVO(universes=6),
    "MVO as run": sky.MVO(universes=6, as_run=True),
    "GSO": sky.GSO(glowworms=6),
    "BBO": sky.BBO(habitats=6),
    "random restart": sky.RandomRestart(samples=6),
    "DE": sky.DE(candidates=6),
    "DE, straight": sky.DE(candidates=6, legs="straight"),
    "PSO": sky.PSO(candidates=6),
    "GWO, straight": sky.GWO(candidates=6, legs="straight"),
}
STOP = sky.MaxIterations(4)
FINE = 1 / 16
NONE = (sky.Status.NO_PATH, sky.Status.NO_PATH_EXISTS, sky.Status.START_SHUT_IN)


def joined(scenario: sky.Scenario, step: float) -> bool:
    """Tell whether start and target are joined on a lattice with this step, by flooding it from both."""
    low, high = np.array(scenario.bounds.min), np.array(scenario.bounds.max)
    shape = np.floor((high - low) / step + 1e-9).astype(int) + 1
    free = np.ones(shape, bool)
    for box in scenario.obstacles:
        first = np.ceil((np.array(box.min) - scenario.clearance - low) / step - 1e-9).astype(int)
        last = np.floor((np.array(box.max) + scenario.clearance - low) / step + 1e-9).astype(int)
        part = tuple(slice(max(a, 0), max(b + 1, 0)) for a, b in zip(first, last, strict=True))
        free[part] = False
    rooms, _ = ndimage.label(free)
    ends = []
    for point in (scenario.uavs[0].start, scenario.targets[0].position):
        near = np.array(np.meshgrid(*[[0, 1]] * 3)).reshape(3, -1).T + np.floor((np.array(point) - low) / step)
        near = near[((near >= 0) & (near < shape)).all(axis=1)].astype(int)
        legs = sky.World(scenario).segments_free(np.tile(point, (len(near), 1)), low + near * step)
        ends.append({int(rooms[tuple(n)]) for n in near[legs]} - {0})
    return bool(ends[0] & ends[1])


def room(seed: int) -> tuple[int, Counter, list[str]]:
    """Let all planners loose in one room; return its seed, what was counted, and what was wrong."""
    scenario = sky.random_room(seed=seed)
    problem = sky.Problem(scenario)
    counted: Counter = Counter()
    wrong = []
    for name, planner in PLANNERS.items():
        result = planner.plan(problem, stop=STOP, rng=seed)
        counted[name, "paths"] += bool(len(result.path))
        counted[name, "reached"] += result.status.reached
        counted[name, "none"] += result.status in NONE
        faults = sky.check_result(scenario, 0, 0, result)
        counted[name, "faults"] += len(faults)
        wrong += [f"room {seed}, {name}: {fault.message}" for fault in faults]
        if result.status in NONE:
            there = joined(scenario, FINE if name == "Taut" else scenario.lattice.step[0])
            counted[name, "denied"] += there
            if there:
                wrong.append(
                    f"room {seed}, {name}: says {result.status.value!r}, but flooding the lattice joins the ends"
                )
    return seed, counted, wrong


def main(rooms: int, first: int = 0) -> None:
    began = time.perf_counter()
    counted: Counter = Counter()
    wrong = []
    room(first)  # compiles
    with get_context("spawn").Pool(cores()) as pool:
        for done, (_, some, complaints) in enumerate(pool.imap_unordered(room, range(first, first + rooms), 16), 1):
            counted += some
            wrong += complaints
            if done % 500 == 0:
                print(f"{done:,} rooms, {time.perf_counter() - began:.0f} s, {len(wrong)} wrong", file=sys.stderr)
    print(f"{describe('scipy')}\n\n{rooms:,} rooms, {time.perf_counter() - began:.0f} s\n")
    kinds = ("paths", "reached", "faults", "none", "denied")
    rows = [[name, *(f"{counted[name, kind]:,}" for kind in kinds)] for name in PLANNERS]
    table(["planner", "paths", "that arrive", "faults found by the referee", "'no path'", "refuted"], rows)
    print("\n".join(wrong))


if __name__ == "__main__":
    main(*(int(word) for word in sys.argv[1:3]) if len(sys.argv) > 1 else (10_000,))
