"""The tables in Markdown, and the notes below them."""

import math
from collections.abc import Mapping, Sequence

from course import Course, median, quartiles
from problems import Case

WITHIN = (0.10, 0.05, 0.01)
AFTER = (0.01, 0.1, 1.0, 10.0)

NOTES = """\
## Terms that are not equal

- Times are processor times of the search, on one core. Setting up (a scenario's world and, where it is used, its
  lattice, or its cells and edges) is in a column of its own; loading Python, libraries and kernels is not counted.
- Taut, Theta*, A* and pathfinding3d end by themselves: one path, no seed, the median time of five calls (pathfinding3d:
  one call, given up after four times the time). All others go on for the whole time, one process a seed.
- Any-angle paths go straight from the true start to the true target, off the lattice. Lattice paths go by its moves,
  with straight legs to the true start and target: the scenario's lattice, 0.1 x 0.1 x 0.5 m on the maps, 5 m in the
  cities; HybridMVO's is 26-connected.
- OMPL's planners are C++, but every test of a point or a segment crosses into Python, which calls skyverse's compiled
  test, and so does the question whether time is up. What a crossing of a test costs is measured, and the calls are
  counted: "without calls" is the time less all crossings, about what a C++ program with the same test would take.
  Settings are OMPL's defaults; segments are tested exactly, not in steps. Coordinates are scaled so that the longest
  side is 20, without which AORRTC crashes in the cities.
- pathfinding3d is pure Python and knows only cells, cubes of 0.25 m that are blocked or not. Its A* goes diagonally
  only between free cells; its Theta* may cut corners, and its line of sight samples cells: the referee says whether it
  went too close. The cities have too many cells for its objects.
- The optimisers of cma and pymoo run in skyverse's loop, on six waypoints joined by straight legs, with a compiled
  objective; schedules follow the number of paths that fit into the time. Map 2 takes more turns than six, but with
  12 or 18 waypoints they arrive no more often.
- Where the reference is the best of this run, a planner of this run has it by definition.
"""


def tables(cases: Sequence[Case], found: Mapping[tuple[str, str], Sequence[Course]], seconds: float) -> str:
    """Return a table a problem, and the table of OMPL's calls."""
    parts = []
    for case in cases:
        of_case = {name: courses for (name, problem), courses in found.items() if problem == case.name}
        parts.append(_table(case, of_case, reference(case, list(of_case.values())), seconds))
    return "\n".join([*parts, _calls(found), NOTES])


def reference(case: Case, groups: Sequence[Sequence[Course]]) -> float:
    """Return the shortest length known, or the best that a path which the referee passed has here."""
    sound = [c.metres(math.inf) for courses in groups for c in courses if not c.trouble]
    return case.known if case.known is not None else min(sound, default=math.inf)


def _table(case: Case, of_case: Mapping[str, Sequence[Course]], best: float, seconds: float) -> str:
    source = "shortest known" if case.known is not None else "the best found here"
    after = [t for t in AFTER if t <= seconds] or [seconds]
    head = ["planner", "path", "seeds", "set-up", *(f"to {w:.0%}" for w in WITHIN), "to 1% without calls"]
    head += [*(f"longer after {t:g} s" for t in after), "referee"]
    rows = []
    for name, courses in of_case.items():
        times = [_times(courses, best * (1 + within)) for within in WITHIN]
        called = any("crossing" in course.facts for course in courses)
        without = _times(courses, best * (1 + WITHIN[-1]), corrected=True) if called else ""
        lengths = [_metres(courses, t, best) for t in after]
        set_up = _seconds(median(courses, lambda c: c.facts.get("set_up", 0.0))) if courses else ""
        rows.append([name, _kind(courses), str(len(courses)), set_up, *times, without, *lengths, _verdict(courses)])
    title = f"## {case.name}\n\nReference {best:.4f} m ({source}), straight line {case.straight:.4f} m.\n"
    return title + "\n" + markdown(head, rows)


def _kind(courses: Sequence[Course]) -> str:
    told = {course.facts["any_angle"] for course in courses if "any_angle" in course.facts}
    return ", ".join("any angle" if kind else "lattice" for kind in sorted(told))


def _times(courses: Sequence[Course], metres: float, corrected: bool = False) -> str:
    """Return the median time to a length, and how many runs got there where not all did."""
    times = [course.time_to(metres, corrected) for course in courses]
    reached = sum(map(math.isfinite, times))
    some = f" ({reached}/{len(times)})" if 0 < reached < len(times) else ""
    return _seconds(median(courses, lambda c: c.time_to(metres, corrected))) + some


def _seconds(seconds: float) -> str:
    if not math.isfinite(seconds):
        return "never"
    return f"{seconds * 1e3:.3g} ms" if seconds < 0.9995 else f"{seconds:.3g} s"


def _metres(courses: Sequence[Course], seconds: float, best: float) -> str:
    """Return by how much the paths of so many seconds are longer than the best: the median, and the quartiles."""

    def metres(course: Course) -> float:
        return course.metres(seconds)

    def above(metres: float) -> str:
        return f"{round(100 * (metres / best - 1), 2) + 0.0:.2f} %" if math.isfinite(metres) else "none"

    middle = above(median(courses, metres))
    low, high = map(above, quartiles(courses, metres))
    return middle if low == high else f"{middle} ({low} to {high})"


def _verdict(courses: Sequence[Course]) -> str:
    troubles = [course.trouble for course in courses if course.trouble]
    return f"{len(troubles)} of {len(courses)}: {troubles[0]}" if troubles else "sound"


def _calls(found: Mapping[tuple[str, str], Sequence[Course]]) -> str:
    """Return the table of what the tests called from C++ cost."""
    rows = []
    for (name, problem), courses in found.items():
        told = [course.facts for course in courses if "crossing" in course.facts]
        if told:
            points, motions = (sum(facts["calls"][k] for facts in told) / len(told) for k in (0, 1))
            cost = [sum(facts["crossing"][k] for facts in told) / len(told) for k in (0, 1)]
            overhead = points * cost[0] + motions * cost[1]
            each = [f"{c * 1e6:.1f} µs" for c in cost]
            rows.append([name, problem, f"{points:,.0f}", each[0], f"{motions:,.0f}", each[1], _seconds(overhead)])
    head = ["planner", "problem", "points tested", "crossing, each", "segments tested", "crossing, each", "in all"]
    return (
        "## Crossings\n\nCrossings from C++ into Python and back, means a run.\n\n" + markdown(head, rows)
        if rows
        else ""
    )


def markdown(head: Sequence[str], rows: Sequence[Sequence[str]]) -> str:
    """Return a table in Markdown."""
    widths = [max(len(row[i]) for row in [head, *rows]) for i in range(len(head))]
    lines = (head, ["-" * width for width in widths], *rows)
    cells = (" | ".join(cell.ljust(width) for cell, width in zip(row, widths, strict=True)) for row in lines)
    return "".join(f"| {line} |\n" for line in cells)
