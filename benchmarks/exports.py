"""Replays exported fleets: whether autopilots that climb and fly faster or slower keep what the export promises.

``python benchmarks/exports.py --fleets 1000`` plans random fleets of two to five UAVs in the open, with and without
``apart_in_space``, exports them, reads the files back and replays each four times at climbs of 1 to 5 m/s, speeds 10 %
off and take-offs from at once to 1.2 times as slow as usual, those for PX4 with what their parameter files say. It
prints how many pairs of UAVs are apart in which way, and how many broke the promise. What goes wrong with one fleet is
printed with its seed, and the run goes on; the exit code is then 1.
"""

import argparse
import sys
import tempfile
import time
from collections import Counter
from collections.abc import Iterable
from concurrent.futures import ProcessPoolExecutor, as_completed
from functools import partial
from multiprocessing import get_context
from pathlib import Path
from typing import NamedTuple

import numpy as np
from machine import describe

import skyverse as sky
from skyverse.exports import Apart, ExportCertificate
from skyverse.numerics.cores import cores

sys.path.insert(0, str(Path(__file__).parent.parent / "tests" / "support"))
sys.path.insert(0, str(Path(__file__).parent.parent / "tests" / "exports"))
from exported_fleets import broken_promises, random_fleet, read_orders

SUFFIXES = ("plan", "waypoints", "wpml.kmz")
PLANNED = {False: "planned as usual", True: "planned apart in space"}
PROGRESS = 20.0
"""Seconds between two lines that tell how far a run is."""


class Replay(NamedTuple):
    """One fleet: how each pair is apart, what broke the promise, and the seconds that it took."""

    kinds: list[Apart]
    broken: list[str]
    seconds: float


def replay(seed: int, *, apart_in_space: bool) -> Replay:
    """Plan, export and replay one fleet."""
    began = time.perf_counter()
    mission = random_fleet(seed, apart_in_space=apart_in_space)
    seen: list[ExportCertificate] = []
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / f"m.{SUFFIXES[seed % 3]}"
        asked = {"apart_in_space": True} if apart_in_space else {"allow_close": True}
        try:
            files = sky.export(mission, path, sky.ExportOptions(**asked), on_certificate=seen.append)
        except sky.InputError:
            files = sky.export(mission, path, sky.ExportOptions(allow_close=True), on_certificate=seen.append)
        orders = read_orders(mission.scenario, files)
    pairs = seen[-1].apart.pairs
    broken = broken_promises(mission, orders, pairs, np.random.default_rng(seed))
    return Replay(list(pairs.values()), [str(pair) for pair in broken], time.perf_counter() - began)


def replays(seeds: Iterable[int], processes: int, *, apart_in_space: bool) -> tuple[list[Replay], int]:
    """Return the replays of all fleets, and of how many something raised an error; print both and the progress."""
    planned = PLANNED[apart_in_space]
    made: list[Replay] = []
    errors, told = 0, time.perf_counter()
    with ProcessPoolExecutor(processes, get_context("spawn")) as pool:
        waiting = {pool.submit(partial(replay, seed, apart_in_space=apart_in_space)): seed for seed in seeds}
        for done in as_completed(waiting):
            seed = waiting[done]
            error = done.exception()
            if error is not None:
                errors += 1
                print(f"seed {seed}, {planned}: {type(error).__name__}: {error}", file=sys.stderr, flush=True)
            else:
                made.append(done.result())
                for pair in made[-1].broken:
                    print(f"seed {seed}, {planned}: broken promise {pair}", file=sys.stderr, flush=True)
            if time.perf_counter() > told + PROGRESS:
                told = time.perf_counter()
                print(f"  {len(made) + errors} of {len(waiting)} fleets, {planned}", file=sys.stderr, flush=True)
    return made, errors


def main() -> int:
    """Replay the fleets and print what was found."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--fleets", type=int, default=30, help="fleets of each kind; 30 by default")
    parser.add_argument("--first", type=int, default=0, help="the first seed")
    parser.add_argument("--processes", type=int, default=cores(), help="processes side by side; all cores by default")
    options = parser.parse_args()
    seeds = range(options.first, options.first + options.fleets)
    print(describe(), flush=True)
    began, broken, failed = time.perf_counter(), 0, 0
    for apart_in_space, planned in PLANNED.items():
        made, errors = replays(seeds, options.processes, apart_in_space=apart_in_space)
        kinds = Counter(kind for one in made for kind in one.kinds)
        whole = sum(set(one.kinds) == {Apart.SPACE} for one in made)
        broken, failed = broken + sum(len(one.broken) for one in made), failed + errors
        longest = max((one.seconds for one in made), default=0.0)
        print(f"{len(made)} fleets from seed {options.first}, {planned}, {longest:.1f} s for the slowest:")
        for kind in Apart:
            print(f"  pairs {kind.value}: {kinds[kind]}")
        print(f"  fleets with all paths apart in space: {whole}", flush=True)
    print(f"broken promises: {broken}; fleets with errors: {failed}; {time.perf_counter() - began:.0f} s")
    return 1 if broken or failed else 0


if __name__ == "__main__":
    raise SystemExit(main())
