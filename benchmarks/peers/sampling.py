"""Planners of OMPL, given skyverse's compiled tests of points and segments.

Every test crosses from C++ into Python and back. What one such call costs is measured, and the calls are counted, so
that the time without them can be told.
"""

import itertools
import time
from collections.abc import Callable
from functools import partial
from typing import Any

import numpy as np
from contenders import MANY
from problems import compiled

import skyverse as sky
from skyverse.numerics.kernel import Stopwatch, inner, kernel
from skyverse.space.ground import Ground
from skyverse.space.obstacles import Space
from skyverse.space.solids import Solids
from skyverse.space.tree import Tree
from skyverse.space.world import point_free, segment_free

LONGEST = 20.0
"""What the longest side of the bounds is scaled to: at 2,000 m a side, AORRTC of OMPL 2.0.1 crashes."""

Tests = tuple[Callable[..., bool], Callable[..., bool]]


def tests_of(space: Space, scale: float) -> Tests:
    """Return the tests of a point (x, y, z) and of a segment, two of them, in scaled coordinates.

    The space's arrays are constants in the code: handing them over at every call would cost ten times the test.
    """
    low, high, boxes, clearance = space.low, space.high, space.boxes, space.clearance
    bounds, nodes = space.tree
    solids, round_, kind, edges, (round_bounds, round_nodes) = space.solids
    heights, origin, step, extra, slope, extremes, levels = space.ground
    tops, corner, cell, below, steep, most, coarser = space.ceiling

    @inner
    def here() -> Space:
        return Space(
            low,
            high,
            boxes,
            clearance,
            Tree(bounds, nodes),
            Solids(solids, round_, kind, edges, Tree(round_bounds, round_nodes)),
            Ground(heights, origin, step, extra, slope, extremes, levels),
            Ground(tops, corner, cell, below, steep, most, coarser),
        )

    @inner
    def place(x: float, y: float, z: float) -> np.ndarray:
        p = np.empty(3)
        p[0], p[1], p[2] = x / scale, y / scale, z / scale
        return p

    @kernel
    def point(x: float, y: float, z: float) -> bool:
        return point_free(here(), place(x, y, z))

    @kernel
    def segment(x: float, y: float, z: float, u: float, v: float, w: float) -> bool:
        return segment_free(here(), place(x, y, z), place(u, v, w))

    point(0.0, 0.0, 0.0), segment(0.0, 0.0, 0.0, 1.0, 1.0, 1.0)
    return point, segment


def seed_first(seed: int) -> None:
    """Seed OMPL, which counts only before anything else of it is used."""
    from ompl import util

    util.RNG.setSeed(seed + 1)
    util.noOutputHandler()


def solve(
    planner: str, scenario: sky.Scenario, seed: int, seconds: float, better: Callable[..., None]
) -> tuple[np.ndarray | None, dict[str, Any]]:
    from ompl import base, geometric

    problem, set_up = compiled(scenario)
    world = problem.airspace.world.space
    scale = LONGEST / float((world.high - world.low).max())
    point, segment = tests_of(world, scale)
    calls = [0, 0]
    best = [np.inf]

    def valid(state: Any) -> bool:
        calls[0] += 1
        return point(state[0], state[1], state[2])

    class Motions(base.MotionValidator):
        def checkMotion(self, a: Any, b: Any) -> bool:  # noqa: N802
            calls[1] += 1
            cost = search.bestCost().value()  # OMPL's callback for better solutions cannot be set from Python
            if cost < best[0]:
                best[0] = cost
                better(time.process_time() - began, cost / scale, *calls)
            return segment(a[0], a[1], a[2], b[0], b[1], b[2])

    clock = Stopwatch()
    room = base.RealVectorStateSpace(3)
    box = base.RealVectorBounds(3)
    for axis in range(3):
        box.setLow(axis, float(world.low[axis] * scale))
        box.setHigh(axis, float(world.high[axis] * scale))
    room.setBounds(box)
    setup = geometric.SimpleSetup(room)
    information = setup.getSpaceInformation()
    setup.setStateValidityChecker(valid)
    motions = Motions(information)
    information.setMotionValidator(motions)
    start, goal = room.allocState(), room.allocState()
    for axis in range(3):
        start[axis], goal[axis] = float(problem.start[axis] * scale), float(problem.end[axis] * scale)
    setup.setStartAndGoalStates(start, goal)
    setup.setOptimizationObjective(base.PathLengthOptimizationObjective(information))
    search = getattr(geometric, planner)(information)
    setup.setPlanner(search)
    setup.setup()
    set_up += clock.seconds
    began = time.process_time()
    setup.solve(base.PlannerTerminationCondition(lambda: time.process_time() - began >= seconds))
    cost = search.bestCost().value()
    if cost < best[0]:
        better(time.process_time() - began, cost / scale, *calls)
    facts = {"set_up": set_up, "any_angle": True, "calls": list(calls)}
    facts["crossing"] = crossings(information, room, world, scale, valid, (point, segment))
    if not setup.haveExactSolutionPath():
        return None, facts
    path = setup.getSolutionPath()
    states = [path.getState(i) for i in range(path.getStateCount())]
    places = np.array([[state[0], state[1], state[2]] for state in states]) / scale
    places[0], places[-1] = problem.start, problem.end
    return places, facts


def crossings(
    information: Any, room: Any, world: Space, scale: float, valid: Any, tests: Tests, samples: int = 2000
) -> list[float]:
    """Return the seconds that a test of a point, and of a segment, takes beyond the compiled test itself."""
    point, segment = tests
    rng = np.random.default_rng(0)
    places = scale * rng.uniform(world.low, world.high, (samples, 3))
    states = [room.allocState() for _ in places]
    for state, place in zip(states, places, strict=True):
        for axis in range(3):
            state[axis] = float(place[axis])

    @kernel
    def points_alone(places: np.ndarray) -> int:
        return sum([point(p[0], p[1], p[2]) for p in places])

    @kernel
    def segments_alone(places: np.ndarray) -> int:
        free = 0
        for i in range(1, len(places)):
            a, b = places[i - 1], places[i]
            free += segment(a[0], a[1], a[2], b[0], b[1], b[2])
        return free

    points_alone(places), segments_alone(places)
    whole = [_clocked(lambda: [information.isValid(s) for s in states])]
    whole.append(_clocked(lambda: [information.checkMotion(a, b) for a, b in itertools.pairwise(states)]))
    alone = [_clocked(lambda: points_alone(places)), _clocked(lambda: segments_alone(places))]
    return [max(0.0, (w - a) / samples) for w, a in zip(whole, alone, strict=True)]


def _clocked(call: Callable[[], object]) -> float:
    began = time.process_time()
    call()
    return time.process_time() - began


CONTENDERS = {
    f"OMPL {name}": {
        "kind": "sampling",
        "run": partial(solve, planner),
        "maps": MANY,
        "cities": MANY,
        "needs": "ompl",
        "prepare": seed_first,
    }
    for name, planner in {"BIT*": "BITstar", "Informed RRT*": "InformedRRTstar", "AORRTC": "AORRTC"}.items()
}
