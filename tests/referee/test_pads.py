"""Pads as the referee sees them: what a UAV stands on, what else is too near, and that players see them alike."""

from itertools import pairwise, product

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import skyverse as sky
from judged_missions import result
from skyverse.referee.pads import holds, pad_of, pads_of, pads_sentence, parts_of_flight
from skyverse.referee.path import judge_ends, judge_safety
from skyverse.referee.sorties import Tour, tour_to
from skyverse.referee.world import referee_world

ERROR = sky.TrackingError(horizontal=1.0, vertical=2.0)
PLACE = (10.0, 10.0, 5.5)
TOP = 5.5 + 2.0 + 0.01
ROOF = sky.Box(min=(6, 6, 0), max=(14, 14, 5))
CLEAR = 1.0 + 1.0
"""Metres: the pad's radius and the error."""


def scenario(*obstacles, error=ERROR, place=PLACE, **changes):
    return sky.Scenario.model_validate(
        {
            "name": "pad",
            "bounds": {"min": (0, 0, 0), "max": (20, 20, 40)},
            "clearance": 0.5,
            "lattice": {"step": (1, 1, 1)},
            "obstacles": obstacles,
            "uavs": ({"start": place, "tracking_error": error},),
            "targets": ({"position": (3, 3, 20)},),
        }
        | changes
    )


def pad(*obstacles, **changes):
    """Return the pad of a start; players lift off from it exactly where the referee sees one, if a way leads out."""
    given = scenario(*obstacles, **changes)
    start, error = given.uavs[0].start, given.uavs[0].tracking_error
    found = pad_of(referee_world(given, error), 0, start)
    above = sky.Airspace(given).of(0).lifted(0, start)[2] - start[2]
    if found is None:
        assert above == 0
    else:
        up = np.linspace(0, found.top - start[2] - 0.002, 300)[:, None] * [0, 0, 1] + start
        assert above > 0 or not sky.World(given, error).free(up).any()
        assert start[2] + above <= found.top
    return found


def beside(kind, away, high, low=0.0):
    """Return a shape of a kind so far east of the pad's axis."""
    x, y = PLACE[0] + away, PLACE[1]
    shapes = {
        "box": lambda: sky.Box(min=(x, y - 1, low), max=(x + 1, y + 1, high)),
        "voxels": lambda: sky.Voxels(origin=(x, y, low), step=(1, 1, high - low), occupied=np.ones((1, 1, 1), bool)),
        "cylinder": lambda: sky.Cylinder(centre=(x + 0.5, y), radius=0.5, low=low, high=high),
        "prism": lambda: sky.Prism(
            vertices=[(x, y - 1), (x + 1, y - 1), (x + 1, y + 1), (x, y + 1)], low=low, high=high
        ),
        "sphere": lambda: sky.Sphere(centre=(x + 0.5, y, high - 0.5), radius=0.5),
    }
    return shapes[kind]()


KINDS = ("box", "voxels", "cylinder", "prism", "sphere")


@pytest.mark.parametrize("kind", KINDS[:-1])
@pytest.mark.parametrize(
    ("away", "high", "low", "there"),
    [
        (0.5, 5.0, 0.0, True),  # a roof as high as the one below
        (0.5, 4.0, 0.0, True),
        (0.5, 5.01, 0.0, False),
        (CLEAR - 0.01, 9.0, 6.0, False),  # a wall
        (CLEAR + 0.01, 9.0, 6.0, True),
        (-0.5, 19.0, TOP + 0.5 + 2.0 + 0.01, True),  # a roof above
        (-0.5, 19.0, TOP + 0.5 + 2.0 - 0.01, False),
    ],
)
def test_from_a_pad_all_keeps_the_error_but_what_the_uav_stands_on(kind, away, high, low, there):
    found = pad(ROOF, beside(kind, away, high, low))
    assert (found is not None) == there
    if there:
        assert found == (PLACE, 1.0, 0.5, pytest.approx(TOP))


@pytest.mark.parametrize(
    ("away", "centre", "there"),
    [(1.0, 4.5, True), (1.0, 4.51, False), (3.4, 6.5, False), (3.6, 6.5, True)],
)
def test_spheres_keep_the_error_by_the_diagonal_of_its_half(away, centre, there):
    ball = sky.Sphere(centre=(PLACE[0] + away, PLACE[1], centre), radius=0.5)
    assert (pad(ROOF, ball) is not None) == there


@pytest.mark.parametrize("kind", KINDS)
def test_where_a_uav_may_stray_from_its_start_it_needs_no_pad(kind):
    below = beside(kind, -0.5, 4.0)
    top = 3.5 + 0.5 + 0.5 + np.hypot(1, 2) if kind == "sphere" else 6.5
    assert pad(below, place=(10, 10, 4.5)) is not None
    assert pad(below, place=(10, 10, top + 1e-5)) is None
    assert pad(below, place=(10, 10, 4.5), error=sky.TrackingError()) is None
    wings = {"start": (10, 10, 4.5), "tracking_error": ERROR}
    wings |= {"fixed_wing": {"speed": 3, "turn_radius": 3, "climb": 30}}
    assert pad(below, uavs=(wings,)) is None


@pytest.mark.parametrize(("rise", "there"), [(0.0, True), (0.7, True), (1.0, True), (1 + 4e-9, False), (4.0, False)])
def test_a_uav_stands_on_ground_unless_it_is_steeper_than_45_degrees(rise, there):
    terrain = sky.Terrain(origin=(0, 0), step=(20, 20), heights=np.array([[0.0, 0.0], [20 * rise, 20 * rise]]))
    around = {"bounds": {"min": (0, 0, -10), "max": (20, 20, 200)}, "max_height": 100.0}
    assert (pad(terrain=terrain, place=(10, 10, 10 * rise + 0.5), **around) is not None) == there


@pytest.mark.parametrize(
    ("x", "y", "there"),
    [
        (9.49, 10.0, True),  # the cells from x = 11 to 13, y = 9 to 11 are steep; the error is 1 m, and 0.5 m are spare
        (9.51, 10.0, False),
        (14.49, 10.5, False),
        (14.51, 10.5, True),
        (12.5, 7.49, True),
        (12.5, 7.51, False),
        (9.9, 7.9, True),  # beyond the corner
        (10.0, 8.0, False),
    ],
)
def test_only_ground_within_the_radius_and_the_error_counts_as_steep(x, y, there):
    heights = np.zeros((21, 21))
    heights[12, 10] = 0.75
    found = pad(terrain=sky.Terrain(origin=(0, 0), step=(1, 1), heights=heights), place=(x, y, 0.5))
    assert (found is not None) == there


@pytest.mark.parametrize("kind", KINDS)
def test_nobody_stands_on_what_is_not_solid(kind):
    below = beside(kind, -0.5, 4.0)
    for solid, kind_named in product((True, False), (None, "no-fly zone", "office space")):
        named = below.model_copy(update={"solid": solid, "kind": kind_named})
        assert (pad(named, place=(10, 10, 4.5)) is not None) == solid


def test_the_floor_of_the_bounds_is_stood_on_but_their_sides_and_top_keep_the_error():
    for x, there in ((10.0, True), (1.5, True), (1.49, False)):
        assert (pad(place=(x, 10.0, 0.5)) is not None) == there
    for high, there in ((0.5 + 2.01 + 2.0, True), (0.5 + 2.0 + 2.0, False)):
        found = pad(place=(10, 10, 0.5), bounds={"min": (0, 0, 0), "max": (20, 20, high)}, targets=())
        assert (found is not None) == there


@pytest.mark.parametrize(("most", "there"), [(2.0 + 2.01 + 0.01, True), (2.0 + 2.01 - 0.01, False)])
def test_a_ceiling_above_ground_keeps_the_error_from_a_pad(most, there):
    terrain = sky.Terrain(origin=(0, 0), step=(20, 20), heights=np.zeros((2, 2)))
    found = pad(terrain=terrain, place=(10, 10, 0.5), max_height=0.5 + most, targets=())
    assert (found is not None) == there


def test_in_a_low_hall_a_uav_whose_error_is_wide_and_flat_takes_off():
    error = sky.TrackingError(horizontal=2.4, vertical=0.2)
    found = pad(place=(10, 10, 0.5), error=error, bounds={"min": (0, 0, 0.4), "max": (20, 20, 2.5)}, targets=())
    assert found.top == pytest.approx(0.71)


def test_a_pad_is_as_wide_as_the_clearance_where_that_is_more_than_the_error():
    assert pad(place=(10, 10, 0.5), clearance=3.0).radius == 3.0
    assert pad(place=(6.01, 10, 0.5), clearance=0.5).radius == 1.0


def test_parts_on_pads_are_judged_without_the_error():
    terrain = sky.Terrain(origin=(0, 0), step=(20, 20), heights=np.zeros((2, 2)))
    judged_in = referee_world(scenario(ROOF, terrain=terrain, max_height=35.0), ERROR)
    legs = [PLACE, [10.4, 10, 7.4], [10, 10, 20], [3, 3, 20]]
    b = np.array([[p, q] for p, q in pairwise(legs)], dtype=float)
    pads = pads_of(judged_in, 0, Tour((0,)))
    assert [noun for noun, _ in pads] == ["start"]
    assert pads_sentence(pads) == (
        "; only on the pad at its start up to z = 7.51 m that error does not count for the ground and roofs below"
    )
    (on_pad, first), (whole, rest) = parts_of_flight(judged_in, 0, Tour((0,)), b, np.zeros(len(b)))
    assert (first, rest) == (slice(0, 1), slice(1, 3))
    assert on_pad is judged_in.nominal
    assert whole is judged_in


def test_every_piece_is_judged_once_and_without_the_error_on_the_pads_alone():
    """A flight and the same flight backwards, from one roof to another, high above what is between."""
    roofs = ROOF, sky.Box(min=(6, 0, 0), max=(14, 4, 8))
    there = (10.0, 2.0, 8.6)
    top = pad_of(referee_world(scenario(*roofs, place=there), ERROR), 0, there).top
    legs = [PLACE, (10.4, 10, 7), (10, 10, TOP), (10, 10, 20), (10, 2, 20), (10, 2, top), there]
    b = np.array([[p, q] for p, q in pairwise(legs)])
    for start, end, flown, on_pads in ((PLACE, there, b, (2, 1)), (there, PLACE, b[::-1, ::-1], (1, 2))):
        world = referee_world(scenario(*roofs, place=start, targets=({"position": end},)), ERROR)
        parts = list(parts_of_flight(world, 0, Tour((0,)), flown, np.zeros(len(b))))
        assert [part for _, part in parts] == [
            slice(0, on_pads[0]),
            slice(on_pads[0], 6 - on_pads[1]),
            slice(6 - on_pads[1], 6),
        ]
        assert [judged_in.error for judged_in, _ in parts] == [sky.TrackingError(), ERROR, sky.TrackingError()]


@pytest.mark.parametrize("above", [0.49, 0.51])
@pytest.mark.parametrize("backwards", [False, True])
def test_a_path_that_comes_too_near_to_a_roof_on_a_pad_is_refuted(above, backwards):
    free, place = (3.0, 3.0, 20.0), (10.0, 10.0, 5 + above)
    ends = [free, place] if backwards else [place, free]
    given = scenario(ROOF, place=ends[0], targets=({"position": ends[1]},))
    path = np.array([place, (10, 10, TOP), (10, 10, 20), free])
    found = list(judge_safety(referee_world(given, ERROR), 0, Tour((0,)), path[::-1] if backwards else path))
    assert [one.fault for one in found] == ([sky.Fault.PATH_CLEARANCE] if above < 0.5 else [])


@pytest.mark.parametrize(("up", "faults"), [(0, []), (1, []), (2, []), (4, [sky.Fault.PATH_ENDS] * 2)])
def test_on_a_pad_the_first_and_last_nodes_may_be_anywhere_above_the_start_and_target(up, faults):
    ends = (10.0, 10.0, 5.6), (10.0, 10.0, 5.7)
    given = scenario(ROOF, place=ends[0], targets=({"position": ends[1]},))
    node = np.array([10.0, 10, 6 + up])
    path = result([node], 1)
    found = judge_ends(referee_world(given, ERROR), 0, tour_to(given, 0, 0), path.path, path)
    assert [one.fault for one in found] == faults


@pytest.mark.parametrize(
    ("change", "error", "held"),
    [
        ((0, 0, 0), 0.0, True),
        ((0.5, 0, 0), 0.0, True),
        ((0.5 + 1e-7, 0, 0), 0.0, False),  # beside it
        ((0.5 - 1e-9, 0, 0), 1e-6, False),
        ((0.36, 0.36, 0), 0.0, False),
        ((0, 0, -5e-7), 0.0, True),
        ((0, 0, -2e-6), 0.0, False),  # below it
        ((0, 0, -5e-7), 8e-7, False),  # perhaps
        ((0, 0, 2e-6), 0.0, False),  # above its top
    ],
)
def test_pieces_are_on_a_pad_that_lie_in_it_as_a_whole(change, error, held):
    found = pad(ROOF)
    whole = np.array([[PLACE, [*PLACE[:2], found.top]]])
    assert holds(found, whole + np.array(change), np.array([error])).tolist() == [held]
    bent = np.insert(whole, 1, PLACE + np.array(change) + (0, 0, found.top - PLACE[2] if change[2] > 0 else 0), axis=1)
    assert holds(found, bent, np.array([error])).tolist() == [held]


@st.composite
def shapes(draw):
    kind = draw(st.sampled_from(KINDS))
    low = draw(st.floats(0, 12))
    shape = beside(kind, draw(st.floats(-6, 5)), low + draw(st.floats(0.5, 9)), low)
    return shape.model_copy(update={"solid": draw(st.booleans())})


@settings(max_examples=150)
@given(st.lists(shapes(), max_size=4), st.sampled_from([0.5, 5.5, 7.3]), st.sampled_from([0.1, 0.5, 2.0]))
def test_players_lift_off_exactly_from_the_pads_that_the_referee_sees(obstacles, height, clearance):
    given_ = scenario(*obstacles, place=(10.0, 10.0, height), clearance=clearance)
    if sky.World(given_).free([given_.uavs[0].start])[0]:
        pad(*obstacles, place=(10.0, 10.0, height), clearance=clearance)
