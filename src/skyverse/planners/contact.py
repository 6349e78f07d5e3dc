"""The time axis of a path's cost: what it costs to be too near to movers, or in zones while they are closed."""

from typing import NamedTuple

from skyverse._typing import Floats, Ints
from skyverse.cost import soft_terms
from skyverse.model.timed_shapes import JUDGED_STAY
from skyverse.numerics.kernel import by_reference, inner_query
from skyverse.problem import Problem
from skyverse.space.contact import FlownLegs, seconds_in_contact
from skyverse.space.lattice import Grid, write_position
from skyverse.space.obstacles import Space
from skyverse.space.timed_shapes import MovingShapes, moving_shapes
from skyverse.space.tracking_error import NO_ERROR
from skyverse.space.world import segment_free


@by_reference
class Contact(NamedTuple):
    """How paths are flown among movers, and what contact costs.

    Attributes
    ----------
    shapes
        Movers, and zones that are closed at times.
    space, shortens
        Where lines of sight lead, and whether flights take them past nodes of a path.
    start, end
        (3,) metres: where flights begin and end.
    speed, acceleration, departs
        The UAV's limits, m/s and m/s^2, and when it departs, seconds.
    second
        The price of a second of contact.
    """

    shapes: MovingShapes
    space: Space
    shortens: bool
    start: Floats
    end: Floats
    speed: float
    acceleration: float
    departs: float
    second: float


def contact_of(problem: Problem) -> Contact:
    """Return what contact costs in a problem.

    A second of it costs as much as a path that ends short of its goal by the metres that the UAV flies in a second.
    """
    scenario, uav = problem.scenario, problem.scenario.uavs[problem.uav]
    speed = uav.max_speed if uav.fixed_wing is None else uav.fixed_wing.speed
    return Contact(
        shapes=problem.airspace.moving,
        space=problem.airspace.world.space,
        shortens=not soft_terms(scenario),
        start=problem.start,
        end=problem.end,
        speed=float(speed),
        acceleration=float(uav.max_acceleration),
        departs=problem.departs,
        second=float(scenario.objective.end * speed),
    )


def without_movers(contact: Contact) -> Contact:
    """Return the same without anything that moves."""
    return contact._replace(shapes=moving_shapes([], NO_ERROR))


@inner_query
def price_of_contact(contact: Contact, grid: Grid, nodes: Ints, goal: int, legs: FlownLegs) -> float:
    """Return what contact costs on the flight along a path of nodes (n,); `legs` is memory for n + 2 corners."""
    count = _flown_corners(contact, grid, nodes, goal, legs.corners)
    return contact.second * seconds_in_contact(
        contact.shapes, legs, count, contact.speed, contact.acceleration, contact.departs, JUDGED_STAY
    )


@inner_query
def _flown_corners(contact: Contact, grid: Grid, nodes: Ints, goal: int, corners: Floats) -> int:
    """Write the corners of the flight along a path of nodes; return how many they are.

    As in `trajectory.path_to_trajectory`, nodes on a straight line are left out, and so are those past which a line of
    sight leads.
    """
    n = len(nodes)
    for axis in range(3):
        corners[0, axis] = contact.start[axis]
    count = 1
    for i in range(n):
        if i == 0 or i == n - 1 or nodes[i] - nodes[i - 1] != nodes[i + 1] - nodes[i]:
            write_position(grid, nodes[i], corners[count])
            count += _differs(corners[count], corners[count - 1])
    if nodes[n - 1] == goal:
        for axis in range(3):
            corners[count, axis] = contact.end[axis]
        count += _differs(corners[count], corners[count - 1])
    if not contact.shortens:
        return count
    kept, i = 0, 0
    while i < count - 1:
        ahead = count - 1
        while ahead > i + 1 and not segment_free(contact.space, corners[i], corners[ahead]):
            ahead -= 1
        if _differs(corners[ahead], corners[kept]):  # a path that comes back to a node may be cut short to it
            kept += 1
            for axis in range(3):
                corners[kept, axis] = corners[ahead, axis]
        i = ahead
    return kept + 1


@inner_query
def _differs(a: Floats, b: Floats) -> int:
    """Return 1 if two places (3,) differ, and 0 if they do not."""
    return int(a[0] != b[0] or a[1] != b[1] or a[2] != b[2])
