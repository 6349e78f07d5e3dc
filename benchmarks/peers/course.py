"""The length of the best path over processor time, of one run and as the quartiles of several."""

import json
import math
import signal
import statistics
import subprocess
import sys
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any, NamedTuple

GRACE = 120.0
"""Seconds that a run may take in addition to its search: for imports, kernels and setting up."""
SLOWER = 10.0
"""How many seconds a second of processor time may last on a busy machine."""


class Step(NamedTuple):
    """A better path: seconds since the search began, without the calls' overhead, and metres."""

    seconds: float
    corrected: float
    metres: float


class Course(NamedTuple):
    """One run: its better paths in order, and what else it told (`facts`); `trouble` says how it failed, if it did."""

    steps: tuple[Step, ...]
    facts: dict[str, Any]
    trouble: str

    def metres(self, seconds: float) -> float:
        """Return the length after some seconds, infinite before there is a path."""
        return min((step.metres for step in self.steps if step.seconds <= seconds), default=math.inf)

    def time_to(self, metres: float, corrected: bool = False) -> float:
        """Return the seconds until the path is as short as that, infinite if it never is."""
        reached = [step for step in self.steps if step.metres <= metres]
        return min((step.corrected if corrected else step.seconds for step in reached), default=math.inf)


def follow(contender: str, problem: str, seed: int, seconds: float) -> Course:
    """Run one contender in a process of its own."""
    script = str(Path(__file__).with_name("run.py"))
    command = [sys.executable, script, contender, problem, str(seed), str(seconds)]
    try:
        ran = subprocess.run(command, capture_output=True, text=True, timeout=SLOWER * seconds + GRACE)
        output, code, complaint = ran.stdout, ran.returncode, ran.stderr
    except subprocess.TimeoutExpired as late:
        given = late.stdout or ""
        output, code, complaint = given if isinstance(given, str) else given.decode(), None, ""
    said = [json.loads(line) for line in output.splitlines() if line.startswith("{") and line.endswith("}")]
    facts = said.pop() if said and "end" in said[-1] else {}
    point, motion = facts.get("crossing", (0.0, 0.0))
    steps = tuple(
        Step(
            row["seconds"],
            max(0.0, row["seconds"] - row["points"] * point - row["motions"] * motion),
            row["metres"],
        )
        for row in said
    )
    return Course(steps, facts, _trouble(facts, code, complaint))


def _trouble(facts: dict[str, Any], code: int | None, complaint: str) -> str:
    if code is None:
        return "still ran long after its time"
    if not facts:
        return f"crashed ({signal.Signals(-code).name})" if code < 0 else (complaint.strip().splitlines() or ["?"])[-1]
    if facts.get("faults") is None:
        return str(facts.get("note", "no path"))
    return "; ".join(facts["faults"][:1])


def median(courses: Sequence[Course], what: Callable[[Course], float]) -> float:
    """Return the median of what the courses say; infinite where half of them never get there."""
    return statistics.median_high([what(course) for course in courses])


def quartiles(courses: Sequence[Course], what: Callable[[Course], float]) -> tuple[float, float]:
    """Return the lower and the upper quartile of what the courses say, two of these values."""
    values = sorted(map(what, courses))
    return values[len(values) // 4], values[(3 * len(values)) // 4]
