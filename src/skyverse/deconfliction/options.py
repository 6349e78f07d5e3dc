"""What a UAV could fly: its own path, and ways through a gate beside the place where it meets others."""

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cached_property
from typing import NamedTuple

import numpy as np

from skyverse._typing import Floats
from skyverse.model.result import Result
from skyverse.model.shapes import Box
from skyverse.model.trajectory import Trajectory
from skyverse.model.uav import UAV
from skyverse.planners.base import planned_any_angle
from skyverse.planners.taut import Taut
from skyverse.problem import Airspace, Problem

Fly = Callable[[Problem, Result], Trajectory | None]

STEP = 1.25
"""Semi-axes between gates that lie side by side: room for two UAVs to pass, and for what a trajectory rounds off."""
ASIDE = (0, 1, -1, 2, -2, 3, -3, 4, -4, 6, -6, 8, -8, 11, -11, 15, -15, 20, -20)
"""Steps to the right, the hand to which the rules of the air turn first, and to the left (negative)."""
OVER = (0, 1, -1, 2, -2, 3, -3, 4, -4)
"""Steps up, and down (negative)."""
HOLE = 0.3
"""Half the width of a gate, semi-axes."""
WALL = 0.01
"""Half the thickness of the wall that a gate is in, metres, less the clearance around it."""


@dataclass(frozen=True)
class Gate:
    """A hole in a wall: what a path that meets others somewhere is led through.

    Attributes
    ----------
    here, point
        Where the path is, and where the hole is, (3,) metres.
    axis
        Which the wall is across.
    beside
        How far off the path the hole is, in words.
    """

    here: tuple[float, float, float]
    point: tuple[float, float, float]
    axis: int
    beside: str


class Gates(NamedTuple):
    """Gates beside a path, the shortest way first.

    Attributes
    ----------
    gates
        m of them.
    aside
        (m, 3) how far off they are, metres.
    stretched
        (m,) by how much longer a way through takes than the path, about.
    """

    gates: list[Gate]
    aside: Floats
    stretched: Floats


@dataclass(frozen=True, eq=False)
class Option:
    """One way for a UAV to its target.

    Attributes
    ----------
    uav, target
        Indices.
    curve
        The number of its trajectory on the shelf.
    seconds
        What it takes.
    result, trajectory
        What is flown, from its own start on.
    gates
        What it is led through; none for its own path.
    """

    uav: int
    target: int | None
    curve: int
    seconds: float
    result: Result | None
    trajectory: Trajectory
    gates: tuple[Gate, ...] = ()

    @cached_property
    def start(self) -> Floats:
        """Where it begins, (3,) metres."""
        return self.trajectory.at(self.trajectory.start).position[0]

    @cached_property
    def end(self) -> Floats:
        """Where it ends, (3,) metres."""
        return self.trajectory.at(self.trajectory.end).position[0]

    @cached_property
    def metres(self) -> float:
        """The length of the flown way, about."""
        instants = np.linspace(self.trajectory.start, self.trajectory.end, 200)
        return float(np.linalg.norm(np.diff(self.trajectory.at(instants).position, axis=0), axis=1).sum())


def gates(airspace: Airspace, option: Option, share: float) -> Gates:
    """Return gates beside an option's path after a share of its time, in free space."""
    uav, trajectory = airspace.scenario.uavs[option.uav], option.trajectory
    since, seconds = trajectory.start, option.seconds
    here = trajectory.at(since + share * seconds).position[0]
    around = trajectory.at(since + np.clip(share + np.array([-0.02, 0.02]), 0.0, 1.0) * seconds).position
    ahead = around[1] - around[0]
    right, up = np.array([ahead[1], -ahead[0], 0.0]), np.array([0.0, 0.0, 1.0])
    wide, tall = uav.ellipsoid
    steep = np.linalg.norm(right) <= 1e-3 * np.linalg.norm(ahead)
    if steep:
        right, up, tall = np.array([0.0, -1.0, 0.0]), np.array([1.0, 0.0, 0.0]), wide
    right /= np.linalg.norm(right)
    steps = np.array([(r, u) for u in OVER for r in ASIDE][1:], dtype=np.float64) * STEP * (wide, tall)
    aside = steps[:, :1] * right + steps[:, 1:] * up
    points = here + aside
    ways = np.linalg.norm(points - option.start, axis=1) + np.linalg.norm(points - option.end, axis=1)
    ways = np.maximum(ways / max(option.metres, 1e-9), 1.0)
    free = airspace.world.free(points)
    chosen = [k for k in np.argsort(ways, kind="stable").tolist() if free[k]]
    axis = int(np.argmax(np.abs(ahead)))
    words = ("ahead", "back") if steep else ("over", "under")
    found = []
    for k in chosen:
        says = [f"{abs(steps[k, 0]):.2g} m to the {'right' if steps[k, 0] > 0 else 'left'}"] if steps[k, 0] else []
        says += [f"{abs(steps[k, 1]):.2g} m {words[0] if steps[k, 1] > 0 else words[1]}"] if steps[k, 1] else []
        found.append(Gate(tuple(here.tolist()), tuple(points[k].tolist()), axis, " and ".join(says)))
    return Gates(found, aside[chosen], ways[chosen])


def _wall(uav: UAV, clearance: float, gate: Gate) -> tuple[Box, ...]:
    """Return the wall that a gate is in: four boxes around the hole, which shut the path where it was."""
    here, point, axis = np.array(gate.here), np.array(gate.point), gate.axis
    wide, tall = uav.ellipsoid
    sizes = np.array([wide, wide, tall])
    reach = 1.5 * np.abs(point - here) + 2.0 * sizes + 2.0 * clearance
    low, high = np.minimum(here, point) - reach, np.maximum(here, point) + reach
    low[axis], high[axis] = point[axis] - WALL, point[axis] + WALL
    hole = HOLE * sizes + clearance
    first, second = (k for k in range(3) if k != axis)
    boxes = []
    for k, bounds in ((first, None), (second, first)):
        for side in (-1, 1):
            a, b = low.copy(), high.copy()
            if side < 0:
                b[k] = point[k] - hole[k]
            else:
                a[k] = point[k] + hole[k]
            if bounds is not None:
                a[bounds], b[bounds] = point[bounds] - hole[bounds], point[bounds] + hole[bounds]
            boxes.append(Box(min=tuple(a.tolist()), max=tuple(b.tolist())))
    return tuple(boxes)


def through(
    airspace: Airspace, uav: int, target: int, ways: tuple[Gate, ...], fly: Fly
) -> tuple[Result, Trajectory] | None:
    """Plan a UAV's way in a world with gates and fly it; its result is one of the world as it is."""
    scenario = airspace.scenario
    walls = [box for gate in ways for box in _wall(scenario.uavs[uav], scenario.clearance, gate)]
    walled = Problem(Airspace(scenario.model_copy(update={"obstacles": (*scenario.obstacles, *walls)})), uav, target)
    planned = Taut(proof=0).plan(walled)
    if not planned.status.reached:
        return None
    trajectory = fly(walled, planned)
    if trajectory is None:
        return None
    true = planned_any_angle(
        Problem(airspace, uav, target),
        planned.path,
        None,
        planned.effort,
        planned.seconds,
        planned.history,
        planned.stopped_by,
        replace(planned.provenance, planner="Taut, led around others"),
    )
    return true, trajectory
