"""One run in a process of its own: ``python benchmarks/peers/run.py CONTENDER PROBLEM SEED SECONDS``.

A line is printed whenever the best length gets shorter, so that a run that crashes tells what it had, and one at the
end with what is to be known of the path.
"""

import json
import sys

import contenders
import numpy as np
from problems import case

import skyverse as sky
from skyverse.planners.base import provenance
from skyverse.planners.results import SearchRecord, any_angle_result


def say(**facts: object) -> None:
    print(json.dumps(facts), flush=True)


def main(name: str, problem: str, seed: int, seconds: float) -> None:
    contender = contenders.ALL[name]
    contender.prepare(seed)
    scenario = case(problem).scenario

    def better(after: float, metres: float, points: int = 0, motions: int = 0) -> None:
        say(seconds=after, metres=metres, points=points, motions=motions)

    path, facts = contender.run(scenario, seed, seconds, better)
    say(end=True, faults=faults(scenario, path), **facts)


def faults(scenario: sky.Scenario, path: np.ndarray | None) -> list[str] | None:
    """Return what the referee finds wrong with a path, ``None`` where there is none."""
    if path is None:
        return None
    record = SearchRecord(provenance("peer", None, None))
    result = any_angle_result(sky.Problem(scenario), path, None, record)
    return [violation.message for violation in sky.check_result(scenario, 0, 0, result)]


if __name__ == "__main__":
    main(sys.argv[1], sys.argv[2], int(sys.argv[3]), float(sys.argv[4]))
