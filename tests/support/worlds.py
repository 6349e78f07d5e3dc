"""Random box worlds, and what is true of them by brute force, with nothing of skyverse but its data.

All coordinates are whole twentieths of a metre, so that truths come out in whole numbers, without rounding, and boxes
often touch nodes, bounds and each other exactly.
"""

import itertools

import numpy as np
from hypothesis import strategies as st

from skyverse.model.scenario import Bounds, Lattice, Objective, Scenario, Target
from skyverse.model.shapes import Box
from skyverse.model.uav import UAV

UNITS = 20  # to a metre

OBJECTIVES = st.one_of(
    st.sampled_from(["thesis", "turns"]),
    st.builds(
        Objective,
        fuel=st.sampled_from([0.1, 1.0, 3.0]),
        divergence=st.sampled_from([0.0, 0.01, 0.3, 1.0, 20.0]),
        end=st.sampled_from([0.0, 80.0]),
        unit=st.sampled_from(["nodes", "metres"]),
    ),
)


@st.composite
def scenarios(draw, uavs=1, targets=1, most_nodes=7, most_boxes=12, objectives=OBJECTIVES, connectivity=(6, 26)):
    """Draw a scenario; its starts and targets lie anywhere in bounds, also in walls."""
    low, high, steps = [], [], []
    for _ in range(3):
        step = draw(st.sampled_from([2, 3, 5, 10, 20]))
        extent = step * draw(st.integers(1, most_nodes - 1)) + draw(st.sampled_from([0, 0, 1]))
        low.append(draw(st.integers(-40, 40)))
        high.append(low[-1] + extent)
        steps.append(step)
    boxes = []
    for _ in range(draw(st.integers(0, most_boxes))):
        corner, size = [], []
        for a, b in zip(low, high, strict=True):
            corner.append(draw(st.integers(a - 5, b + 2)))
            size.append(draw(st.one_of(st.just(1), st.integers(1, 8), st.integers(1, b - a + 10))))
        top = [c + s for c, s in zip(corner, size, strict=True)]
        boxes.append(Box(min=metres(corner), max=metres(top)))
    places = st.tuples(
        *(
            st.one_of(st.integers(a, b).map(lambda v: v / UNITS), st.floats(a / UNITS, b / UNITS))
            for a, b in zip(low, high, strict=True)
        )
    )
    return Scenario(
        name="random",
        bounds=Bounds(min=metres(low), max=metres(high)),
        obstacles=tuple(boxes),
        clearance=draw(st.sampled_from([0.02, 0.02, 1, 2, 5])) / UNITS,
        lattice=Lattice(step=metres(steps), connectivity=draw(st.sampled_from(connectivity))),
        objective=draw(objectives),
        uavs=tuple(
            UAV(
                start=draw(places),
                max_speed=draw(st.sampled_from([0.5, 5.0])),
                max_acceleration=draw(st.sampled_from([0.4, 3.5])),
            )
            for _ in range(uavs)
        ),
        targets=tuple(Target(position=draw(places)) for _ in range(targets)),
    )


def metres(units):
    return tuple(v / UNITS for v in units)


def whole(values):
    """Metres to whole units, (..., 3) integers."""
    return np.rint(np.array(values, dtype=float) * UNITS).astype(np.int64)


def shape_of(scenario):
    """Nodes per axis: how many whole steps fit into the bounds, and one."""
    low, high = whole(scenario.bounds.min), whole(scenario.bounds.max)
    return tuple(int(n) for n in (high - low) // whole(scenario.lattice.step) + 1)


def indices_of(scenario):
    """(n, 3) index triples, in the order of node numbers."""
    return np.array(list(itertools.product(*(range(n) for n in shape_of(scenario)))))


def grown(scenario):
    """(m, 3) and (m, 3) corners of the grown boxes, in units."""
    growth = whole([scenario.clearance])[0]
    low = whole([b.min for b in scenario.obstacles]).reshape(-1, 3) - growth
    high = whole([b.max for b in scenario.obstacles]).reshape(-1, 3) + growth
    return low, high


def exits_of(scenario, moves):
    """(nodes, moves) booleans: the closed block that a move spans stays in bounds and meets no closed grown box."""
    shape, indices, step = shape_of(scenario), indices_of(scenario), whole(scenario.lattice.step)
    box_low, box_high = grown(scenario)
    open_ = np.zeros((len(indices), len(moves)), bool)
    for m, move in enumerate(np.asarray(moves)):
        there = indices + move
        inside = np.all((there >= 0) & (there < shape), axis=1)
        a, b = (whole(scenario.bounds.min) + i * step for i in (indices, there))
        low, high = np.minimum(a, b)[:, None], np.maximum(a, b)[:, None]
        open_[:, m] = inside & ~np.any(np.all((low <= box_high) & (high >= box_low), axis=2), axis=1)
    return open_


def neighbours(connectivity):
    """(k, 3) index steps, independent of the order that skyverse numbers them in."""
    steps = np.array([m for m in itertools.product((-1, 0, 1), repeat=3) if any(m)])
    return steps[np.abs(steps).sum(axis=1) == 1] if connectivity == 6 else steps


def price_of(scenario, path, goal=None):
    """Equation 3.4 of a path of places (n, 3), written out: fuel, divergence, end."""
    objective = scenario.objective
    steps = np.diff(path, axis=0)
    lengths = np.sqrt((steps**2).sum(axis=1))
    used = objective.fuel * (len(path) if objective.unit == "nodes" else lengths.sum())
    signs = np.rint(steps / np.array(scenario.lattice.step))
    turns = sum(bool(np.any(np.cross(a, b))) for a, b in itertools.pairwise(signs))
    gap = 0.0 if goal is None else np.sqrt(((path[-1] - np.array(goal)) ** 2).sum())
    return used, objective.divergence * turns, objective.end * gap


ROOM = Scenario(
    name="room",
    bounds=Bounds(min=(0, 0, 0), max=(6, 5, 4)),
    obstacles=(Box(min=(2.4, 0, 0), max=(2.6, 3.4, 4)), Box(min=(4.4, 1.6, 0), max=(4.6, 5, 4))),
    clearance=0.25,
    lattice=Lattice(step=(0.5, 0.5, 0.5)),
    uavs=(UAV(start=(0.6, 0.7, 1.2)),),
    targets=(Target(position=(5.8, 4.3, 3.1)),),
)
"""Two walls with a gap at opposite ends: a small problem that no straight walk solves."""


def hall(*obstacles, start, target, **changes):
    """A hall of 10 m by 10 m by 5 m in which length is priced; boxes may be given as their two corners."""
    boxes = tuple(Box(min=one[0], max=one[1]) if isinstance(one, tuple) else one for one in obstacles)
    given = {
        "clearance": 0.001,
        "lattice": Lattice(step=(0.5, 0.5, 0.5), connectivity=changes.pop("connectivity", 26)),
        "objective": Objective(unit="metres"),
    }
    return Scenario(
        name="hall",
        bounds=Bounds(min=(0, 0, 0), max=changes.pop("size", (10, 10, 5))),
        obstacles=boxes,
        uavs=(UAV(start=start),),
        targets=(Target(position=target),),
        **{**given, **changes},
    )
