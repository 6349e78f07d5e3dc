"""Detours of a UAV around others: paths through a gate beside, above or below the place of a conflict."""

import math
from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np

from skyverse._typing import Floats
from skyverse.cost import prices_length_alone
from skyverse.deconfliction.candidate import Candidate, Gate
from skyverse.model.quantities import derived
from skyverse.model.result import Effort, Result, Status
from skyverse.model.scenario import Scenario
from skyverse.model.shapes import Box, Prism
from skyverse.model.trajectory import Trajectory
from skyverse.model.uav import UAV, kept_ellipsoid
from skyverse.numerics.kernel import Stopwatch
from skyverse.numerics.tolerances import MIN_COMPARED_LENGTH
from skyverse.planners.base import provenance
from skyverse.planners.cheapest import Cheapest
from skyverse.planners.results import SearchRecord, lattice_result
from skyverse.planners.taut import Taut
from skyverse.problem import Airspace, Problem
from skyverse.space.lattice import Grid

MakeTrajectory = Callable[[Problem, Result], Trajectory | None]
"""Turns a problem's result into a trajectory, or into ``None`` where none can be proven."""

GATE_SPACING = 1.25
"""Semi-axes from one gate to the next: two UAVs can pass each other, and trajectories may cut corners."""
STEPS_RIGHT = (0, 1, -1, 2, -2, 3, -3, 4, -4, 6, -6, 8, -8, 11, -11, 15, -15, 20, -20)
"""Spacings to the right, the side to which the rules of the air turn first, and to the left (negative)."""
STEPS_UP = (0, 1, -1, 2, -2, 3, -3, 4, -4)
"""Spacings up, and down (negative)."""
HOLE_HALF_WIDTH = 0.3
"""Half the width of a gate's hole, semi-axes."""
WALL_HALF_THICKNESS = 0.01
"""Half the thickness of a gate's wall, metres, without the clearance around it."""
DIRECTION_SHARE = 0.02
"""The share of a flight's time before and after a point of it by which its direction there is measured."""
DETOUR_LEGS = 20_000
"""The legs that `Cheapest` may price for one detour, of which many are tried."""
DETOUR_PROOF = 20
"""The `proof` of `Taut` for one detour, whose bound tells nothing: other ways round are sought, but not for long."""
STEEP = 1e-3
"""The sine of the angle to the vertical below which a path counts as vertical."""


def gates_beside(airspace: Airspace, candidate: Candidate, share: float) -> tuple[list[Gate], Floats, Floats]:
    """Return the gates in free space beside a candidate's trajectory after a share of its time, the shortest way first.

    Those beside a path on the lattice are centred on a line of nodes, so that a path on the lattice leads through them.

    Returns
    -------
    tuple
        m gates; their offsets from the path, (m, 3) metres; and the estimated length of the detour through each,
        divided by that of the path, (m,).
    """
    airspace = airspace.of(candidate.uav)
    uav, trajectory = airspace.scenario.uavs[candidate.uav], candidate.trajectory
    since, seconds = trajectory.start, candidate.seconds
    passed = trajectory.at(since + share * seconds).position[0]
    shares = np.clip(share + np.array([-DIRECTION_SHARE, DIRECTION_SHARE]), 0.0, 1.0)
    before, after = trajectory.at(since + shares * seconds).position
    ahead = after - before
    right, up = np.array([ahead[1], -ahead[0], 0.0]), np.array([0.0, 0.0, 1.0])
    semi_axis_xy, semi_axis_z = kept_ellipsoid(uav, uav)
    if math.hypot(*right) <= STEEP * math.hypot(*ahead):
        right, up, semi_axis_z = np.array([0.0, -1.0, 0.0]), np.array([1.0, 0.0, 0.0]), semi_axis_xy
    right /= math.hypot(*right)
    spacing = np.array([semi_axis_xy, semi_axis_z])
    steps = np.array([(r, u) for u in STEPS_UP for r in STEPS_RIGHT][1:], dtype=np.float64) * GATE_SPACING * spacing
    offsets = steps[:, :1] * right + steps[:, 1:] * up
    axis = int(np.argmax(np.abs(ahead)))
    if candidate.result is not None and not candidate.result.any_angle:
        offsets = _on_lattice(airspace.grid, passed + offsets, axis) - passed
        steps = np.column_stack([np.sum(offsets * right, axis=1), np.sum(offsets * up, axis=1)])
        far = np.linalg.norm(steps / spacing, axis=1) >= 1.0
        offsets = offsets[far]
    centres = passed + offsets
    lengths = np.linalg.norm(centres - candidate.start, axis=1) + np.linalg.norm(centres - candidate.end, axis=1)
    ratios = np.maximum(lengths / max(candidate.metres, MIN_COMPARED_LENGTH), 1.0)
    free = airspace.world.free(centres)
    chosen = [k for k in np.argsort(ratios, kind="stable").tolist() if free[k]]
    found = [Gate(tuple(passed.tolist()), tuple(centres[k].tolist()), axis) for k in chosen]
    return found, offsets[chosen], ratios[chosen]


def _on_lattice(grid: Grid, centres: Floats, axis: int) -> Floats:
    """Return the centres of gates (n, 3) moved to the nearest lines of nodes along an axis; each line once, (m, 3)."""
    cells = np.clip(np.round((centres - grid.origin) / grid.step), 0, grid.shape - 1)
    lines = grid.origin + cells * grid.step
    lines[:, axis] = centres[:, axis]
    _, first = np.unique(np.delete(cells, axis, axis=1), axis=0, return_index=True)
    moved: Floats = lines[np.sort(first)]
    return moved


def _wall(uav: UAV, clearance: float, gate: Gate) -> tuple[Box, ...]:
    """Return a gate's wall: four boxes around the hole, which block the path where it was.

    For the planner they grow by the clearance and by the UAV's tracking error, like obstacles. The error, which is
    contained in the spacing already, is taken off beforehand.
    """
    passed, centre, axis = np.array(gate.passed), np.array(gate.centre), gate.axis
    semi_axis_xy, semi_axis_z = kept_ellipsoid(uav, uav)
    semi_axes = np.array([semi_axis_xy, semi_axis_xy, semi_axis_z])
    error = np.array([uav.tracking_error.horizontal, uav.tracking_error.horizontal, uav.tracking_error.vertical])
    reach = 1.5 * np.abs(centre - passed) + 2.0 * semi_axes + 2.0 * clearance - error
    low, high = np.minimum(passed, centre) - reach, np.maximum(passed, centre) + reach
    low[axis], high[axis] = centre[axis] - WALL_HALF_THICKNESS, centre[axis] + WALL_HALF_THICKNESS
    hole = HOLE_HALF_WIDTH * semi_axes + clearance + error
    boxes = []
    for k in (k for k in range(3) if k != axis):
        before, after = high.copy(), low.copy()
        before[k], after[k] = centre[k] - hole[k], centre[k] + hole[k]
        for a, b in ((low, before), (after, high)):
            boxes.append(Box(min=tuple(a.tolist()), max=tuple(b.tolist())))
        low[k], high[k] = before[k], after[k]
    return tuple(boxes)


def plan_detour(
    problem: Problem, within: Scenario, gates: tuple[Gate, ...], make_trajectory: MakeTrajectory, *, any_angle: bool
) -> tuple[Result, Trajectory] | None:
    """Plan a path through gates and a trajectory along it, or return ``None`` where there is none; see `plan_among`."""
    uav = within.uavs[problem.uav]
    walls = [box for gate in gates for box in _wall(uav, within.clearance, gate)]
    return plan_among(problem, within, walls, make_trajectory, any_angle=any_angle)


def plan_among(
    problem: Problem,
    within: Scenario,
    walls: Sequence[Box | Prism],
    make_trajectory: MakeTrajectory,
    *,
    any_angle: bool,
) -> tuple[Result, Trajectory] | None:
    """Plan a path among obstacles and walls, and a trajectory along it, or return ``None`` where there is none.

    Parameters
    ----------
    problem
        The UAV and its target, without walls; the result is one of this problem.
    within
        The scenario that the path is planned in: the problem's, or one with more obstacles.
    walls
        Further obstacles.
    make_trajectory
        Turns the path into a trajectory.
    any_angle
        Whether the path may leave the lattice. It is then a shortest one, or, where more than length is priced, a cheap
        one. Otherwise it is a cheapest one on the lattice, so that its cost is in the objective's unit.
    """
    among = derived(within, obstacles=(*within.obstacles, *walls)) if walls else within
    walled = Problem(Airspace(among), problem.uav, problem.target)
    found = _path_of_any_angle(problem, walled) if any_angle else _cheapest_on_lattice(problem, walled)
    trajectory = None if found is None else make_trajectory(walled, found)
    return None if found is None or trajectory is None else (found, trajectory)


def _path_of_any_angle(problem: Problem, walled: Problem) -> Result | None:
    """Return a path among the walls as a result of the problem without them, if there is a path.

    It is a shortest one where length alone is priced, and otherwise one that is cheap under the whole objective.
    """
    planner = Taut(proof=DETOUR_PROOF) if prices_length_alone(problem.scenario) else Cheapest(legs=DETOUR_LEGS, proof=0)
    planned = planner.plan(walled)
    same = np.array_equal(walled.start, problem.start) and np.array_equal(walled.end, problem.end)
    if not planned.status.reached or not same:  # a wall may leave no place for the top of a column
        return None
    origin = replace(planned.provenance, planner=f"{type(planner).__name__}, led around others")
    # its bound is one among the walls
    return replace(planned, provenance=origin, bound=None, straight_bound=False, status=Status.COMPLETE)


def _cheapest_on_lattice(problem: Problem, walled: Problem) -> Result | None:
    """Return a cheapest path on the lattice among the walls as a result of the problem without them, if there is one.

    Both problems must have the same nodes for the UAV's start and target.
    """
    ends = problem.source, problem.goal
    if problem.refusal is not None or walled.refusal is not None or (walled.source, walled.goal) != ends:
        return None
    clock = Stopwatch()
    route = walled.route
    if route is None:
        return None
    effort = Effort(generated_paths=1, generated_nodes=route.expanded, evaluations=1)
    origin = provenance("AStar, led around others", None, None)
    return lattice_result(problem, route.nodes, SearchRecord(origin, effort, clock.seconds))
