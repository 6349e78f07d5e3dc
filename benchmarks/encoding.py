"""What the method contributes and what the encoding: ``python benchmarks/encoding.py [--runs 50] [--paths 1000]``.

MVO, GSO and BBO, each on walks over the lattice by the thesis's Algorithm 2 (towards the goal), on walks by Algorithm 1
(uniform), and on vectors of waypoints, on the thesis's three maps at equal numbers of generated paths; and what it does
to MVO and BBO if they discard changes that cost more. For each, how many runs reach the goal, and the mean cost of all
runs, in which a path that ends short pays 100 for each metre. The last lines say how often a run of one row is cheaper
than one of another (A12), averaged over the maps: of the two methods with one encoding, and of the two encodings with
one method.
"""

import argparse
from itertools import combinations, product

import numpy as np
from machine import describe, table

import skyverse as sky
from skyverse.lab import a12

ENCODINGS = {
    "walks by Algorithm 2": {"MVO": sky.MVO(), "GSO": sky.GSO(), "BBO": sky.BBO()},
    "walks by Algorithm 1": {name: getattr(sky, name)(generator="uniform") for name in ("MVO", "GSO", "BBO")},
    "waypoints": {name: getattr(sky, f"Waypoint{name}")() for name in ("MVO", "GSO", "BBO")},
    "walks by Algorithm 2, greedy": {"MVO": sky.MVO(greedy=True), "BBO": sky.BBO(greedy=True)},
    "waypoints, greedy": {"MVO": sky.WaypointMVO(greedy=True), "BBO": sky.WaypointBBO(greedy=True)},
}
MAPS = ("map1", "map2", "map3")


def main() -> None:
    """Run everything, and print the tables."""
    parser = argparse.ArgumentParser(description=__doc__.split("\n\n")[0])
    parser.add_argument("--runs", type=int, default=50)
    parser.add_argument("--paths", type=int, default=1000)
    asked = parser.parse_args()
    print(describe(), end="\n\n")
    problems = {name: sky.Problem(sky.read(name)) for name in MAPS}
    costs, lines = {}, []
    for encoding, methods in ENCODINGS.items():
        for method, planner in methods.items():
            line = [encoding, method]
            for name, problem in problems.items():
                found = [planner.plan(problem, stop=sky.MaxPaths(asked.paths), rng=k) for k in range(asked.runs)]
                costs[encoding, method, name] = np.array([result.cost for result in found])
                reached = sum(result.status.reached for result in found)
                line.append(f"{reached}, {costs[encoding, method, name].mean():,.1f}")
            lines.append(line)
    table(("encoding", "method", *MAPS), lines)

    def cheaper(one: tuple[str, str], other: tuple[str, str]) -> str:
        return f"{np.mean([a12(costs[*other, name], costs[*one, name]) for name in MAPS]):.2f}"

    by_method = [
        (encoding, f"{a} against {b}", cheaper((encoding, a), (encoding, b)))
        for encoding in list(ENCODINGS)[:3]
        for a, b in combinations(("MVO", "GSO", "BBO"), 2)
    ]
    by_encoding = [
        (method, f"{a} against {b}", cheaper((a, method), (b, method)))
        for method, (a, b) in product(("MVO", "GSO", "BBO"), combinations(list(ENCODINGS)[:3], 2))
    ]
    greedy = [
        (method, f"{a} against {a}, greedy", cheaper((a, method), (f"{a}, greedy", method)))
        for method, a in product(("MVO", "BBO"), ("walks by Algorithm 2", "waypoints"))
    ]
    table(("with", "one is cheaper than the other", "A12"), [*by_method, *by_encoding, *greedy])


if __name__ == "__main__":
    main()
