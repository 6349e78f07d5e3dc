"""Run times of two versions of skyverse, interleaved: ``python benchmarks/kernels_ab.py BEFORE/src [CASE ...]``.

Each version runs in a process of its own, with its own compiled kernels. Each round runs every case once in both, so
that whatever else the machine does meets both alike. Prints medians of the processor time of 30 rounds.
"""

import argparse
import os
import subprocess
import sys
import time
from collections.abc import Callable
from pathlib import Path
from statistics import median
from typing import Any

HERE = Path(__file__).parents[1] / "src"


def cases() -> dict[str, Callable[[], Any]]:
    """Return what is timed, by name; through names that both versions have."""
    import skyverse as sky

    found: dict[str, Callable[[], Any]] = {}
    for name in ("map1", "map2", "map3"):
        problem = sky.Problem(sky.read_scenario(name))
        found[f"MVO {name}"] = lambda p=problem: sky.MVO().plan(p, rng=1)
        found[f"A* {name}"] = lambda p=problem: sky.AStar().plan(p)
        found[f"Theta* {name}"] = lambda p=problem: sky.ThetaStar().plan(p)
        found[f"Taut {name}"] = lambda p=problem: sky.Taut().plan(p)
    hills = sky.Problem(sky.read("jacksboro"))
    found["Taut jacksboro"] = lambda: sky.Taut().plan(hills)
    fleet = sky.read("table-4.8")
    found["mission table-4.8, trajectories and all"] = lambda: sky.plan_mission(fleet, sky.Taut(), rng=1)
    return found


def serve(names: list[str]) -> None:
    """Time a case whenever its name comes in, after each has run once."""
    chosen = {name: case for name, case in cases().items() if not names or any(part in name for part in names)}
    for case in chosen.values():
        case()
    print(*chosen, sep="\t", flush=True)
    for line in sys.stdin:
        began = time.process_time()
        chosen[line.rstrip("\n")]()
        print(time.process_time() - began, flush=True)


def main() -> None:
    """Time both versions."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("before", help="the src folder of the other version; 'serve' is for the script itself")
    parser.add_argument("names", nargs="*", help="parts of the names of the cases; all by default")
    parser.add_argument("--rounds", type=int, default=30)
    options = parser.parse_args()
    if options.before == "serve":
        serve(options.names)
        return
    versions = []
    for source in (Path(options.before).resolve(), HERE):
        command = [sys.executable, __file__, "serve", *options.names]
        environment = {**os.environ, "PYTHONPATH": str(source)}
        pipe = subprocess.PIPE
        versions.append(subprocess.Popen(command, stdin=pipe, stdout=pipe, text=True, env=environment))
    names = [version.stdout.readline().rstrip("\n").split("\t") for version in versions if version.stdout][-1]
    times: dict[str, list[list[float]]] = {name: [[], []] for name in names}
    for _ in range(options.rounds):
        for name in names:
            for version, spent in zip(versions, times[name], strict=True):
                print(name, file=version.stdin, flush=True)
                spent.append(float(version.stdout.readline()) if version.stdout else 0.0)
    print("| case | before, ms | after, ms | after / before |\n|---|---|---|---|")
    for name, (before, after) in times.items():
        a, b = median(before) * 1e3, median(after) * 1e3
        print(f"| {name} | {a:.2f} | {b:.2f} | {b / a:.2f} |")
    for version in versions:
        version.kill()


if __name__ == "__main__":
    main()
