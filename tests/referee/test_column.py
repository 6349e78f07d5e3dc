"""Columns as the referee sees them: where they end, and what must be kept in them."""

from itertools import pairwise, product

import numpy as np
import pytest

import skyverse as sky
from skyverse.model.shapes import Box, Cylinder, Prism, Sphere, Terrain, Voxels
from skyverse.referee.clearance import judge_segments
from skyverse.referee.column import column_over, columns_of, parts_of_flight, without_below
from skyverse.referee.world import referee_world

ERROR = sky.TrackingError(horizontal=1.0, vertical=2.0)
FOOT = np.array([10.0, 10.0, 5.5])
ROOF = Box(min=(6, 6, 0), max=(14, 14, 5))


def world(*obstacles, error=ERROR, **changes):
    given = {
        "name": "column",
        "bounds": {"min": (0, 0, 0), "max": (20, 20, 40)},
        "clearance": 0.5,
        "lattice": {"step": (1, 1, 1)},
        "obstacles": obstacles,
        "uavs": ({"start": tuple(FOOT), "tracking_error": error},),
        "targets": ({"position": (3, 3, 20)},),
    }
    return referee_world(sky.Scenario.model_validate(given | changes), error)


def beside(kind, away, high, low=0.0):
    """Return a shape of a kind so far east of the column."""
    x, y = FOOT[0] + away, FOOT[1]
    shapes = {
        "box": lambda: Box(min=(x, y - 1, low), max=(x + 1, y + 1, high)),
        "voxels": lambda: Voxels(origin=(x, y, low), step=(1, 1, high - low), occupied=np.ones((1, 1, 1), bool)),
        "cylinder": lambda: Cylinder(centre=(x + 0.5, y), radius=0.5, low=low, high=high),
        "prism": lambda: Prism(vertices=[(x, y - 1), (x + 1, y - 1), (x + 1, y + 1), (x, y + 1)], low=low, high=high),
        "sphere": lambda: Sphere(centre=(x + 0.5, y, high - 0.5), radius=0.5),
    }
    return shapes[kind]()


KINDS = ("box", "voxels", "cylinder", "prism", "sphere")


def kept(judged_in, foot, top):
    """Tell whether the vertical line from a foot to z = `top` is clear and within bounds."""
    ends = np.array([foot, [*foot[:2], top]])
    judged = judge_segments(judged_in, ends[:1], ends[1:])
    return (
        judged.incursion is None and bool(judged.peaks.proven[0]) and bool((judged_in.beyond_bounds(ends) == 0).all())
    )


@pytest.mark.parametrize("kind", KINDS[:-1])
@pytest.mark.parametrize(
    ("away", "high", "low", "clear"),
    [
        (0.5, 5.0, 0.0, True),  # a roof as high as the one below
        (0.5, 4.0, 0.0, True),
        (0.5, 5.01, 0.0, False),
        (1.49, 9.0, 6.0, False),  # a wall
        (1.51, 9.0, 6.0, True),
        (-0.5, 12.0, 10.1, True),  # a roof above
        (-0.5, 12.0, 9.9, False),
    ],
)
def test_in_a_column_everything_keeps_the_error_but_what_lies_below(kind, away, high, low, clear):
    judged_in = world(ROOF, beside(kind, away, high, low))
    column = column_over(judged_in, 0, FOOT)
    assert column.top >= 7.5 - 1e-5
    assert kept(column.beside, FOOT, 7.5) == clear
    assert not kept(judged_in, FOOT, 7.5)
    numbers = [number for kind in (column.beside.boxes, *column.beside.others) for number in kind.obstacle]
    assert set(numbers) <= {1}
    assert column.beside.error == ERROR


@pytest.mark.parametrize(
    ("away", "centre", "clear"),
    [(1.0, 4.5, True), (1.0, 4.51, False), (3.2, 6.5, False), (3.3, 6.5, True), (0.0, 10.7, False), (0.0, 10.8, True)],
)
def test_spheres_keep_the_error_by_the_diagonal_of_its_half(away, centre, clear):
    ball = Sphere(centre=(FOOT[0] + away, FOOT[1], centre), radius=0.5)
    assert kept(column_over(world(ROOF, ball), 0, FOOT).beside, FOOT, 7.5) == clear


@pytest.mark.parametrize("kind", KINDS)
def test_a_column_ends_where_the_uav_may_stray_from_what_lies_below(kind):
    below = beside(kind, -0.5, 4.0)
    column = column_over(world(below), 0, FOOT - [0, 0, 1])
    top = 3.5 + 0.5 + 0.5 + np.hypot(1, 2) if kind == "sphere" else 6.5
    assert column.top == pytest.approx(top, abs=1e-5)
    assert column_over(world(below), 0, np.array([10.0, 10.0, top])) is None
    assert column_over(world(below, error=sky.TrackingError()), 0, FOOT - [0, 0, 1]) is None


@pytest.mark.parametrize(("rise", "kept_up_to"), [(0.0, 2.5), (0.7, 3.2), (1.0, 3.5), (1.01, None), (1.45, None)])
def test_in_a_column_ground_is_exempt_unless_it_is_steeper_than_45_degrees(rise, kept_up_to):
    terrain = Terrain(origin=(0, 0), step=(20, 20), heights=np.array([[0.0, 0.0], [20 * rise, 20 * rise]]))
    judged_in = world(terrain=terrain, bounds={"min": (0, 0, -10), "max": (20, 20, 200)}, max_height=100)
    foot = np.array([10.0, 10.0, 10 * rise + 0.5])
    column = column_over(judged_in, 0, foot)
    assert kept(column.beside, foot, column.top) == (kept_up_to is not None)
    if kept_up_to is not None:
        assert column.top == pytest.approx(10 * rise + kept_up_to)
        assert not kept(column.beside, foot, foot[2] + 99)  # the ceiling


@pytest.mark.parametrize(("rise", "there_is_one"), [(1.45, True), (1.55, False), (4.0, False)])
def test_a_column_is_no_higher_than_clearance_and_errors(rise, there_is_one):
    terrain = Terrain(origin=(0, 0), step=(20, 20), heights=np.array([[0.0, 0.0], [20 * rise, 20 * rise]]))
    judged_in = world(terrain=terrain, bounds={"min": (0, 0, -10), "max": (20, 20, 200)})
    assert (column_over(judged_in, 0, np.array([10.0, 10.0, 10 * rise + 0.5])) is not None) == there_is_one


@pytest.mark.parametrize(
    ("x", "y", "exempt"),
    [
        (9.99, 10.0, True),  # the cells from x = 11 to 13, y = 9 to 11 are steep, and the error is 1 m
        (10.01, 10.0, False),
        (13.99, 10.5, False),
        (14.01, 10.5, True),
        (12.5, 7.99, True),
        (12.5, 8.01, False),
        (12.0, 11.99, False),
        (12.0, 12.01, True),
        (10.2, 8.2, True),  # beyond the corner
        (10.4, 8.4, False),
        (13.6, 11.6, False),
        (13.8, 11.8, True),
    ],
)
def test_only_ground_within_the_error_counts_as_steep(x, y, exempt):
    heights = np.zeros((21, 21))
    heights[12, 10] = 0.75
    judged_in = world(terrain=Terrain(origin=(0, 0), step=(1, 1), heights=heights))
    foot = np.array([x, y, 0.5])
    column = column_over(judged_in, 0, foot)
    assert kept(column.beside, foot, column.top) == exempt


def test_without_a_horizontal_error_no_ground_is_beside_a_column():
    terrain = Terrain(origin=(0, 0), step=(1, 1), heights=np.add.outer(2.0 * np.arange(21), np.zeros(21)))
    judged_in = world(
        terrain=terrain, error=sky.TrackingError(vertical=2.0), bounds={"min": (0, 0, 0), "max": (20, 20, 80)}
    )
    foot = np.array([10.0, 10.0, 20.5])
    assert kept(column_over(judged_in, 0, foot).beside, foot, 22.5)


@pytest.mark.parametrize("kind", KINDS)
def test_in_a_column_airspace_that_ends_below_keeps_the_error(kind):
    below = beside(kind, -0.5, 4.0)
    for solid, kind_named in product((True, False), (None, "no-fly zone", "office space")):
        judged_in = world(below.model_copy(update={"solid": solid, "kind": kind_named}))
        foot = FOOT - [0, 0, 1]
        column = column_over(judged_in, 0, foot)
        assert kept(column.beside, foot, foot[2] + 1) == solid if column is not None else not solid


def test_in_a_column_the_floor_of_the_bounds_is_exempt_but_not_their_sides():
    judged_in = world()
    for x, clear in ((10.0, True), (1.0, True), (0.99, False)):
        foot = np.array([x, 10.0, 0.5])
        column = column_over(judged_in, 0, foot)
        assert column.top == 2.0
        assert kept(column.beside, foot, 2.0) == clear
        assert not kept(judged_in, foot, 2.0)


def test_of_many_prisms_those_about_a_column_keep_their_outlines():
    rng = np.random.default_rng(1)
    prisms = []
    for x, y in rng.uniform(5, 15, (60, 2)):
        corners = [(x, y), (x + 1, y), (x + 1, y + 1), (x, y + 1)][: rng.integers(3, 5)]
        prisms.append(Prism(vertices=corners, low=0, high=rng.uniform(1, 30)))
    judged_in = world(*prisms)
    place, roof = np.array([10.0, 10.0, 6.0]), 6.0
    around = without_below(judged_in, place, roof)
    tall = tuple(one for one in prisms if one.high > roof)
    (near,), (all_tall,) = around.others, world(*tall).others
    assert len(near.obstacle) > 2
    found, known = (np.hstack(kind.hulls()).tolist() for kind in (near, all_tall))
    assert all(hull in known for hull in found)
    for height in np.linspace(6, 30, 40):
        point = np.array([10, 10, height])
        assert kept(around, point, height) == kept(world(*tall), point, height)


@pytest.mark.parametrize("away", [0.0, 0.3, 1.2])
def test_a_column_beside_the_middle_of_a_sphere_is_lower(away):
    column = column_over(world(Sphere(centre=(10 + away, 10, 4), radius=1)), 0, FOOT)
    assert column.top == pytest.approx(4 + np.sqrt((1 + 0.5 + np.hypot(1, 2)) ** 2 - away**2), abs=1e-5)


def test_parts_in_columns_are_judged_without_the_error_and_with_it_among_what_is_not_exempt():
    judged_in = world(ROOF)
    legs = [FOOT, [10, 10, 7.4], [10, 10, 20], [3, 3, 20]]
    b = np.array([[p, q] for p, q in pairwise(legs)], dtype=float)
    columns = columns_of(judged_in, 0, 0)
    assert columns.target is None
    assert columns.sentence == (
        "; only in the column over its start up to z = 7.5 m that error does not count for the ground and roofs below"
    )
    (one, first), (other, same), (whole, rest) = parts_of_flight(judged_in, 0, 0, b, np.zeros(len(b)))
    assert (first, same, rest) == (slice(0, 1), slice(0, 1), slice(1, 3))
    assert one is judged_in.nominal
    assert other.error == ERROR
    assert whole is judged_in


@pytest.mark.parametrize(
    ("change", "error", "held"),
    [
        ((0, 0, 0), 0.0, True),
        ((5e-7, -5e-7, 0), 0.0, True),
        ((5e-7, 0, 0), 6e-7, False),
        ((2e-6, 0, 0), 0.0, False),  # beside the line
        ((0, -2e-6, 0), 0.0, False),
        ((0, 0, -5e-7), 0.0, True),
        ((0, 0, -2e-6), 0.0, False),  # below the foot
        ((0, 0, 1.1e-3), 0.0, True),
        ((0, 0, 2.1e-3), 0.0, False),  # above the top
    ],
)
def test_pieces_are_in_a_column_to_within_what_is_let_pass(change, error, held):
    column = column_over(world(ROOF), 0, FOOT)
    whole = np.array([[FOOT, [*FOOT[:2], column.top]]])
    assert column.holds(whole + np.array(change), np.array([error])).tolist() == [held]
    bent = np.insert(whole, 1, FOOT + np.array(change) + (0, 0, column.top - FOOT[2] if change[2] > 0 else 0), axis=1)
    assert column.holds(bent, np.array([error])).tolist() == [held]


@pytest.mark.parametrize("way", [(1, 0), (-1, 0), (0, 1), (0, -1)])
@pytest.mark.parametrize(("away", "is_near"), [(1.5005, True), (1.5015, False)])
def test_shapes_that_a_column_meets_but_for_a_millimetre_are_looked_at(way, away, is_near):
    middle = FOOT[:2] + (away + 1) * np.array(way)
    wall = Box(min=(*(middle - 1), 0), max=(*(middle + 1), 30))
    column = column_over(world(ROOF, wall), 0, FOOT)
    assert column.beside.boxes.obstacle.tolist() == [1] * is_near


@pytest.mark.parametrize("kind", KINDS[:-1])
@pytest.mark.parametrize(("away", "is_below"), [(1.45, True), (1.55, False)])
def test_what_is_below_a_column_is_all_that_the_error_may_reach(kind, away, is_below):
    column = column_over(world(beside(kind, away, 4.0)), 0, FOOT - [0, 0, 1])
    assert (column is not None) == is_below
    assert column is None or column.top == pytest.approx(6.5, abs=1e-5)
