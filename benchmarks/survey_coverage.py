"""The certificate of coverage beside rays that share no code with it: random ground, buildings, straight down, aslant.

What is claimed must hold in every world that rays try, in which each camera is off and turned by as much as may be; and
what rays find certain, by a little more than that, the certificate should not miss.
"""

import sys
import time
from pathlib import Path


def coverage(count: int = 200, first: int = 0) -> None:
    """Print false claims, false alarms and verdicts over so many cases of random ground."""
    sys.path.insert(0, str(Path(__file__).parent.parent / "tests" / "support"))
    from photographed import found_of, random_case

    began, missed, certain, wrong = time.perf_counter(), 0.0, 0.0, 0
    verdicts: dict[tuple[bool, str], int] = {}
    for seed in range(first, first + count):
        case = random_case(seed)
        found = found_of(case, count=300, seed=seed)
        missed, certain, wrong = missed + found.missed, certain + found.certain, wrong + len(found.wrong)
        key = found.holds, found.coverage.verdict.value
        verdicts[key] = verdicts.get(key, 0) + 1
        for said in found.wrong[:3]:
            print(f"case {seed}: FALSE: {said}", flush=True)
        if found.holds and found.coverage.verdict.value != "proven":
            print(f"case {seed}: not proven though it holds: {found.coverage.sentence}", flush=True)
        if (seed + 1) % 10 == 0:
            share = f"{100 * missed / max(certain, 1e-9):.2f} % of what is certain missed"
            print(f"{seed + 1 - first} cases: {wrong} false claims, {share}; {verdicts}", flush=True)
    proven = verdicts.get((True, "proven"), 0)
    hold = sum(number for (holds, _), number in verdicts.items() if holds)
    print(f"{count} cases, {time.perf_counter() - began:.0f} s: {wrong} false claims")
    print(f"certain to be seen, but not counted: {100 * missed / max(certain, 1e-9):.2f} % of the area")
    print(f"proven: {proven} of {hold} that hold with a margin of 1 degree and 2 % of the distance")
