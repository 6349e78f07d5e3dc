"""Whether the check of missions finds what is wrong, at the right items, and nothing else.

``python benchmarks/planted_faults.py 300`` makes 300 random missions with one planted fault each, and 300 without, as
files for PX4, ArduPilot and DJI over random ground, buildings and zones, and has them checked. What is true of them
comes from dense samples that share nothing with skyverse (tests/support/planted_worlds.py). It prints how many were
found, by kind, and each miss and false alarm with its seed; the exit code is then 1.
"""

import argparse
import statistics
import sys
import time
from concurrent.futures import ProcessPoolExecutor
from functools import partial
from multiprocessing import get_context
from pathlib import Path
from typing import NamedTuple

import numpy as np
from machine import describe, table

from skyverse.numerics.cores import cores

sys.path.insert(0, str(Path(__file__).parent.parent / "tests" / "support"))
from planted_missions import FAULTS, unharmed
from planting import harmed, judged, mistakes


class Outcome(NamedTuple):
    """One case: its fault, what was missed and what falsely found, and the seconds of the check."""

    kind: str
    seed: int
    missed: list[str]
    false: list[str]
    seconds: float


def outcome(seed: int, *, fault: bool) -> Outcome:
    """Make and judge one case."""
    kind = FAULTS[seed % len(FAULTS)] if fault else "none"
    rng = np.random.default_rng([seed, int(fault)])
    dji = seed % 3 == 2
    case = harmed(rng, kind, dji=dji) if fault else unharmed(rng, two=seed % 6 == 0, dji=dji)
    try:
        began = time.perf_counter()
        found = judged(case)
        seconds = time.perf_counter() - began
    except Exception as error:
        return Outcome(kind, seed, [f"{type(error).__name__}: {error}"], [], 0.0)
    return Outcome(kind, seed, *mistakes(case, found), seconds)


def main() -> int:
    """Judge the missions and print what was found."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("count", type=int, nargs="?", default=30, help="missions with a fault, and without")
    parser.add_argument("--seed", type=int, default=0, help="the first seed")
    parser.add_argument("--processes", type=int, default=cores(), help="processes side by side; all cores by default")
    options = parser.parse_args()
    seeds = range(options.seed, options.seed + options.count)
    print(describe(), flush=True)
    made: list[Outcome] = []
    with ProcessPoolExecutor(options.processes, get_context("spawn")) as pool:
        for fault in (True, False):
            for one in pool.map(partial(outcome, fault=fault), seeds):
                made.append(one)
                if len(made) % 50 == 0:
                    print(f"  {len(made)} of {2 * options.count} missions", file=sys.stderr, flush=True)
                for what, said in (("missed", one.missed), ("false alarm", one.false)):
                    for line in said[:3]:
                        print(f"seed {one.seed}, fault {one.kind}: {what}: {line}", flush=True)
    rows = []
    for kind in (*FAULTS, "none"):
        of = [one for one in made if one.kind == kind]
        right, false = sum(not one.missed for one in of), sum(bool(one.false) for one in of)
        slow = statistics.median(one.seconds for one in of) if of else 0.0
        rows.append([kind, str(len(of)), str(right), str(false), f"{slow:.2f} s"])
    table(("planted fault", "missions", "all found", "with a false alarm", "median check"), rows)
    return 1 if any(one.missed or one.false for one in made) else 0


if __name__ == "__main__":
    raise SystemExit(main())
