"""Skyverse beside other planners: ``python benchmarks/peers`` writes tables and a figure of length against time.

It needs the extras `bench`, `ompl` and `optimisers`; what is not installed is left out, and named.
"""

import argparse
import sys
from pathlib import Path

import contenders
from course import Course, follow
from figure import draw
from problems import NAMES, case
from report import tables

PACKAGES = {"ompl": "ompl", "pathfinding3d": "pathfinding3d", "cma": "cma", "pymoo": "pymoo"}


def main(words: list[str]) -> None:
    asked = _options(words)
    folder = Path(asked.output)
    folder.mkdir(parents=True, exist_ok=True)
    problems = [name for name in asked.only if name in NAMES] or list(("map1",) if asked.quick else NAMES)
    planners = [name for name in asked.only if name in contenders.ALL] or list(contenders.ALL)
    missing = [name for name in planners if not contenders.ALL[name].installed]
    found: dict[tuple[str, str], list[Course]] = {}
    for problem in problems:
        for name in planners:
            seeds = 0 if name in missing else contenders.ALL[name].seeds(problem)
            seeds = min(seeds, asked.seeds)
            for seed in range(seeds):
                print(f"{problem}: {name}, seed {seed}", file=sys.stderr, flush=True)
                found.setdefault((name, problem), []).append(follow(name, problem, seed, asked.seconds))
    if not found:
        sys.exit("none of these planners takes part in these problems")
    cases = [case(problem) for problem in problems if any(key[1] == problem for key in found)]
    text = "\n".join([_machine(), *_left_out(missing), tables(cases, found, asked.seconds)])
    print(text)
    (folder / "peers.md").write_text(text, encoding="utf-8")
    draw(cases, found, asked.seconds, folder)
    print(f"written: {', '.join(str(folder / f'peers.{kind}') for kind in ('md', 'png', 'svg'))}")


def _options(words: list[str]) -> argparse.Namespace:
    parser = argparse.ArgumentParser(prog="python benchmarks/peers", description="Skyverse beside other planners.")
    parser.add_argument(
        "--seconds", type=float, help="processor time of each run of a planner that does not end by itself (10)"
    )
    parser.add_argument("--only", nargs="+", default=[], metavar="NAME", help="planners, problems, or both")
    parser.add_argument("--seeds", type=int, default=5, help="of planners that draw random numbers (5)")
    parser.add_argument("--quick", action="store_true", help="map1, one seed, one second")
    parser.add_argument("-o", "--output", default="out/peers", help="folder to write to (out/peers)")
    asked = parser.parse_args(words)
    names = [*NAMES, *contenders.ALL]
    unknown = [name for name in asked.only if name not in names]
    if unknown:
        parser.error(f"there is no {unknown[0]!r}; there are {', '.join(names)}")
    if asked.seconds is None:
        asked.seconds = 1.0 if asked.quick else 10.0
    if asked.quick:
        asked.seeds = 1
    if asked.seeds < 1:
        parser.error(f"--seeds takes a number from 1 on, not {asked.seeds}")
    if not asked.seconds > 0:
        parser.error(f"--seconds takes a number above 0, not {asked.seconds:g}")
    return asked


def _machine() -> str:
    sys.path.append(str(Path(__file__).parents[1]))
    from machine import describe

    installed = {contender.needs for contender in contenders.ALL.values() if contender.installed}
    return describe(*(package for module, package in PACKAGES.items() if module in installed)) + "\n"


def _left_out(missing: list[str]) -> list[str]:
    return [f"Left out, {contenders.ALL[name].needs} is not installed: {name}\n" for name in missing]


if __name__ == "__main__":
    main(sys.argv[1:])
