"""Chooses the first tier of tests: ``python benchmarks/first_tier.py --seconds 400`` writes ``tests/second_tier.txt``.

First come the tests that together run every line of the source that any test runs, chosen one after another by the new
lines that each runs in a second; then the cheapest of all others, until the seconds of processor time are spent.
`measured_tests.py` has to be run before.
"""

import argparse
import heapq

import numpy as np
from measured_tests import ROOT, MeasuredTests, load

LEAST_SECONDS = 0.02
"""Below this, a test's cost is that of running any test at all."""


def cover(tests: MeasuredTests, budget: float) -> list[int]:
    """Return tests that together run every line, as far as the budget of seconds goes, the most telling first."""
    cost, missing = np.maximum(tests.seconds, LEAST_SECONDS), np.ones(len(tests.lines), dtype=np.int32)
    # a test's new lines only get fewer, so that the one whose count is still right when it comes first is the best
    heap = [(-lines / cost[k], k) for k, lines in enumerate(tests.runs.sum(axis=1)) if lines]
    heapq.heapify(heap)
    chosen = []
    while heap:
        worth, k = heapq.heappop(heap)
        lines = tests.runs.indices[tests.runs.indptr[k] : tests.runs.indptr[k + 1]]
        new = int(missing[lines].sum())
        if new and -new / cost[k] > worth:
            heapq.heappush(heap, (-new / cost[k], k))
        elif new and cost[k] <= budget:
            budget -= cost[k]
            missing[lines] = 0
            chosen.append(k)
    return chosen


def main() -> None:
    """Choose, write the list, and print what each part costs."""
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--seconds", type=float, default=400.0, help="of processor time that the first tier may take")
    budget = parser.parse_args().seconds
    tests = load()
    first = cover(tests, budget)
    cost = np.maximum(tests.seconds, LEAST_SECONDS)
    print(f"{len(first)} tests run every line that the first tier runs, in {cost[first].sum():.0f} s")
    spent = cost[first].sum()
    for k in np.argsort(cost, kind="stable"):
        if k not in set(first) and spent + cost[k] <= budget:
            first.append(k)
            spent += cost[k]
    chosen = set(first)
    second = sorted(name for k, name in enumerate(tests.names) if k not in chosen)
    (ROOT / "tests" / "second_tier.txt").write_text("\n".join(second) + "\n", encoding="utf-8")
    lines = np.asarray(tests.runs[first].sum(axis=0)).ravel() > 0
    print(f"first tier: {len(first)} tests, {spent:.0f} s, {lines.sum()} of {len(lines)} lines")
    print(f"second tier: {len(second)} tests, {cost.sum() - spent:.0f} s")


if __name__ == "__main__":
    main()
