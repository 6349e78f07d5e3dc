"""Lines over the ground beside dense samples of what their photos show: how finely, how much of it, and what not."""

import math
import re
from itertools import pairwise

import numpy as np
import pytest
import shapely
from hypothesis import given, settings
from hypothesis import strategies as st

import skyverse as sky
from skyverse.model.asked_ground import asked_ground
from skyverse.space.world import World
from skyverse.survey.ground_lines import ground_lines
from skyverse.survey.ground_survey import GroundSurvey, Pass
from skyverse.survey.spacing import ReliefOffsets, unit
from skyverse.survey.strip_lines import StripFlown, lines_along
from skyverse.survey.sweep_lines import across

FIELD = ((0.0, 0.0), (160.0, 0.0), (160.0, 120.0), (0.0, 120.0))
ELL = ((0.0, 0.0), (200.0, 0.0), (200.0, 80.0), (90.0, 80.0), (90.0, 190.0), (0.0, 190.0))
PARTS = (
    {"vertices": FIELD, "holes": (((40.0, 30.0), (70.0, 35.0), (60.0, 80.0)),)},
    {"vertices": ((170.0, 20.0), (230.0, 30.0), (200.0, 110.0))},
)
GSD = 0.01
ERROR = {"horizontal": 0.8, "vertical": 0.6}


def scenario(survey, heights=None, **given):
    uav = sky.UAV(
        name="one",
        start=(-70.0, -70.0, 0.0 if heights is None else float(heights.max()) + 9.0),
        end="home",
        max_speed=12.0,
        max_climb=4.0,
        max_descent=3.0,
        tracking_error=given.pop("error", ERROR),
    )
    top = 150.0 if heights is None else float(heights.max()) + 150.0
    ground = {} if heights is None else {"terrain": {"origin": (-150, -150), "step": (10, 10), "heights": heights}}
    bounds = {"min": (-140.0, -140.0, 0.0), "max": (340.0, 340.0, top)}
    return sky.Scenario(name="field", bounds=bounds, clearance=2.0, uavs=(uav,), surveys=(survey,), **ground, **given)


def relief(seed: int, steepest: float = 25.0) -> np.ndarray:
    """Return (50, 50) heights, 10 m apart, some place of which is as steep as said."""
    rng = np.random.default_rng(seed)
    x, y = np.meshgrid(np.arange(50) * 10.0, np.arange(50) * 10.0, indexing="ij")
    h = np.zeros_like(x)
    for _ in range(8):
        kx, ky = rng.normal(0, 2 * math.pi / 120, 2)
        h += rng.normal() * np.sin(kx * x + ky * y + rng.uniform(0, 6.3))
    slope = np.hypot(*np.gradient(h, 10.0)).max()
    return (h - h.min()) * math.tan(math.radians(steepest)) / slope


def photos(line):
    """Return where the photos of a line are taken (n, 3), and the unit vectors in which the camera looks (n, 2)."""
    legs = np.hypot(*np.diff(line.path[:, :2], axis=0).T)
    way = np.r_[0.0, np.cumsum(legs)]
    at = np.linspace(0.0, way[-1], round(way[-1] / line.every) + 1 if line.every else 1)
    where = np.column_stack([np.interp(at, way, line.path[:, k]) for k in range(3)])
    if line.heading is not None:
        angle = math.radians(line.heading)
        return where, np.tile([math.sin(angle), math.cos(angle)], (len(at), 1))
    if len(line.path) == 1:
        return where, np.array([[0.0, 1.0]])
    leg = np.clip(np.searchsorted(way, at, side="right") - 1, 0, len(legs) - 1)
    return where, (np.diff(line.path[:, :2], axis=0) / legs[:, None])[leg]


def places(area, step):
    x0, y0, x1, y1 = area.bounds
    # both sides and all corners, besides a grid
    x, y = np.meshgrid(np.linspace(x0, x1, int((x1 - x0) / step) + 2), np.linspace(y0, y1, int((y1 - y0) / step) + 2))
    rim = shapely.get_coordinates(shapely.segmentize(area.boundary, step))
    found = np.concatenate([np.column_stack([x.ravel(), y.ravel()]), rim])
    return found[shapely.intersects_xy(area, found)]


def looks(scenario, line, xy):
    """Return of each photo and place (n, m): ahead, beside, below, depth, and height in the picture."""
    ground = np.zeros(len(xy)) if scenario.terrain is None else scenario.terrain.height(xy)
    where, ahead = photos(line)
    dx, dy = xy[None, :, 0] - where[:, :1], xy[None, :, 1] - where[:, 1:2]
    a, b = dx * ahead[:, :1] + dy * ahead[:, 1:], dx * ahead[:, 1:] - dy * ahead[:, :1]
    drop = where[:, 2:] - ground[None]
    c, s = math.cos(math.radians(line.pitch)), math.sin(math.radians(-line.pitch))
    return a, b, drop, a * c + drop * s, a * s - drop * c


def in_picture(scenario, line, xy):
    across, along = scenario.surveys[0].camera.half_widths
    _, b, _, depth, high = looks(scenario, line, xy)
    return (np.abs(b) <= across * depth) & (np.abs(high) <= along * depth), depth


def certain(scenario, line, xy):
    """Tell of each photo and place whether it is shown however the camera is off, by the planes of the view."""
    camera, error = scenario.surveys[0].camera, scenario.uavs[0].tracking_error
    e, (across, along) = math.sin(math.radians(camera.attitude_error)), camera.half_widths
    a, b, drop, depth, high = looks(scenario, line, xy)
    far = np.sqrt(a * a + b * b + drop * drop) + math.hypot(error.horizontal, error.vertical)
    c, s = math.cos(math.radians(line.pitch)), math.sin(math.radians(-line.pitch))
    shown = np.ones(a.shape, dtype=bool)
    for half, at, normal in (
        (across, b, (half_c := across * c, -1.0, across * s)),
        (across, -b, (half_c, 1.0, across * s)),
        (along, high, (along * c - s, 0.0, along * s + c)),
        (along, -high, (along * c + s, 0.0, along * s - c)),
    ):
        shift = math.hypot(*normal[:2]) * error.horizontal + abs(normal[2]) * error.vertical
        shown &= half * depth - at >= math.hypot(*normal) * far * e + shift
    return shown


def require_covered(scenario, lines, step=4.0):
    """Require that all places are certain to be seen, but those that are told not to be."""
    wanted = asked_ground(scenario.surveys[0])
    xy = places(wanted, step)
    seen = np.zeros(len(xy), dtype=bool)
    for line in lines.lines:
        seen |= certain(scenario, line, xy).any(axis=0)
    gaps = shapely.union_all([shapely.Polygon(gap.outline) for gap in lines.unseen]).buffer(3.0)
    assert shapely.intersects_xy(gaps, xy[~seen]).all()
    return float(seen.mean())


@settings(max_examples=20, deadline=None)
@given(st.integers(0, 10**6), st.sampled_from(["photo", "place"]), st.sampled_from([FIELD, PARTS]))
def test_over_relief_all_is_seen_finely_and_clear_of_the_ground(seed, gsd_of, area):
    survey = sky.Survey(area, "mavic-3e", gsd=GSD, gsd_of=gsd_of, direction=30.0 * (seed % 12))
    given = scenario(survey, relief(seed))
    lines = ground_lines(given, 0)
    assert require_covered(given, lines) == 1.0
    assert not lines.unseen
    camera, error = survey.camera, given.uavs[0].tracking_error
    xy = places(asked_ground(survey), 3.0)
    best = np.full(len(xy), np.inf)
    e = math.radians(camera.attitude_error)
    for line in lines.lines:
        shown, depth = in_picture(given, line, xy)
        a, b, drop, *_ = looks(given, line, xy)
        far = np.sqrt(a * a + b * b + drop * drop)
        angle = np.maximum(np.arccos(np.clip(depth / far, -1, 1)) - e, 0.0)
        off = error.vertical + math.hypot(error.horizontal, error.vertical) * math.sin(e)
        gsd = np.where(shown, camera.pixel * (far * np.cos(angle) + off), np.inf)
        best = np.minimum(best, gsd.min(axis=0))
        if gsd_of == "photo":
            assert gsd[shown].max(initial=0.0) <= GSD * (1 + 1e-9)
        legs = np.diff(line.path, axis=0)
        assert (np.abs(legs[:, 2]) <= 1.0 * np.hypot(legs[:, 0], legs[:, 1]) + 1e-6).all()
        assert World(given, error).segments_free(line.path[:-1], line.path[1:]).all()
        assert line.every == 0.0 or line.speed <= line.every / camera.min_interval + 1e-9
    assert best.max() <= GSD * (1 + 1e-9)


@settings(max_examples=20, deadline=None)
@given(st.integers(0, 10**6), st.sampled_from([FIELD, PARTS]))
def test_photos_overlap_over_relief_as_asked(seed, area):
    survey = sky.Survey(area, "mavic-3e", gsd=GSD, overlap=(75, 60), direction=15.0 * (seed % 24))
    given = scenario(survey, relief(seed))
    lines = ground_lines(given, 0).lines
    where = [photos(line) for line in lines]

    def shared(one, other, ahead):
        """Return what photos share of what the one of them shows that shows less, by points one metre apart."""
        shown = []
        for place in (one, other):
            dx, dy, drop = xy[:, 0] - place[0], xy[:, 1] - place[1], place[2] - ground
            a, b = dx * ahead[0] + dy * ahead[1], dx * ahead[1] - dy * ahead[0]
            shown.append((np.abs(b) <= across * drop) & (np.abs(a) <= along * drop))
        return (shown[0] & shown[1]).sum() / max(min(one.sum() for one in shown), 1)

    across, along = survey.camera.half_widths
    xy = places(asked_ground(survey), 1.0)
    ground, area, spare = given.terrain.height(xy), asked_ground(survey), []
    way = where[0][1][0]
    offsets = np.array([one[0, 0] * way[1] - one[0, 1] * way[0] for one, _ in where])
    for number, (row, ahead) in enumerate(where):
        pairs = [(one, other, 0.75) for one, other in pairwise(row)]
        beside = np.flatnonzero(offsets > offsets[number] + 1.0)
        nearest = beside[offsets[beside] < offsets[beside].min(initial=np.inf) + 1.0]
        for other in nearest:
            path = lines[other].path
            at, start = (path[:, :2] - path[0, :2]) @ way, path[0, :2] @ way
            for one in row:
                along_it = one[:2] @ way - start
                if 0.0 <= along_it * np.sign(at[-1]) <= abs(at[-1]):
                    z = np.interp(along_it * np.sign(at[-1]), at * np.sign(at[-1]), path[:, 2])
                    pairs.append((one, np.r_[path[0, :2] + along_it * way, z], 0.6))
        for one, other, asked in pairs:
            if area.contains(shapely.Point(0.5 * (one + other)[:2])):
                spare.append(shared(one, other, ahead[0]) - asked)
    assert (np.array(spare) >= -0.02).mean() >= 0.995  # a row of points is 2 % of a picture
    assert np.median(spare) <= 0.15


@settings(max_examples=20, deadline=None)
@given(st.integers(0, 10**6))
def test_strips_over_steep_relief_are_interrupted_only_where_no_height_suits(seed):
    given = scenario(sky.Survey(FIELD, "mavic-3e", gsd=0.003), relief(seed, 55.0))  # as near as the clearance allows
    task = GroundSurvey(given, 0)
    sight, ends = task.sight(-90.0), np.array([[0.0, 60.0], [160.0, 60.0]])
    lines = list(lines_along(StripFlown(task, sight, Pass(-90.0, 0.0), sight.steps[1]), ends))
    at = np.arange(0.25, 160.0, 0.5)
    floor, most = sight.heights(at, np.column_stack([at, np.full_like(at, 60.0)]), np.tile([1.0, 0.0], (320, 1)), 0.25)
    flown = sum(np.hypot(*(line.path[-1] - line.path[0])[:2]) for line in lines)
    assert flown >= 0.8 * 0.5 * (floor <= most).sum() - 5.0


@settings(max_examples=20, deadline=None)
@given(st.integers(0, 10**6), st.floats(0.0, 359.0))
def test_strips_over_gentle_relief_are_about_as_far_from_each_other(seed, direction):
    given = scenario(sky.Survey(ELL, "mavic-3e", gsd=GSD, direction=direction), relief(seed, 6.0))
    task = GroundSurvey(given, 0)
    way = unit(direction)
    low, _, high, _ = across(task.wanted, way).bounds
    offsets = ReliefOffsets(task.sight(-90.0))(way, task.wanted, low, high)
    gaps = np.diff(np.r_[2 * low - offsets[0], offsets, 2 * high - offsets[-1]])
    assert gaps.min() >= 0.5 * gaps.max()


@pytest.mark.parametrize("heights", [None, relief(4, 12.0)], ids=["level", "relief"])
@pytest.mark.parametrize(("pattern", "most"), [("strips", 2.0), ("cross", 4.0), ("oblique", 8.0)])
def test_slanting_photos_are_not_many_more_than_those_straight_down(pattern, most, heights):
    given = {"area": ELL, "camera": "mavic-3e", "gsd": 0.02, "direction": 0.0}
    down, slanting = (
        sum(len(photos(line)[0]) for line in ground_lines(scenario(sky.Survey(**given, **more), heights), 0).lines)
        for more in ({}, {"pattern": pattern, "gimbal": -50.0})
    )
    assert slanting <= most * down


@settings(max_examples=20, deadline=None)
@given(st.integers(0, 10**6))
def test_areas_with_holes_and_zones_are_seen_up_to_their_borders_and_zones_are_not_entered(seed):
    rng = np.random.default_rng(seed)
    hole = ((20.0, 20.0), (45.0, 22.0), (40.0, 50.0))
    zones = []
    for number in range(int(rng.integers(0, 4))):
        x, y, r = *rng.uniform(0, 190, 2), rng.uniform(5, 25)
        corners = [(x + r * math.cos(t), y + r * math.sin(t)) for t in (0.2, 1.9, 3.7, 5.2)]
        zones.append(
            sky.Prism(vertices=corners, low=0.0, high=200.0, name=f"z{number}", kind="no-fly zone", solid=False)
        )
    survey = sky.Survey(({"vertices": ELL, "holes": (hole,)},), "mavic-3e", gsd=GSD, margin=float(rng.uniform(0, 9)))
    given = scenario(survey, obstacles=tuple(zones))
    lines = ground_lines(given, 0)
    assert require_covered(given, lines) > (0.999 if not zones else 0.5)
    world = World(given, given.uavs[0].tracking_error)
    assert all(world.segments_free(line.path[:-1], line.path[1:]).all() for line in lines.lines)
    assert all(gap.why.startswith("no ") for gap in lines.unseen)


def test_what_a_zone_hides_is_told_with_its_name():
    zone = sky.Box(min=(30.0, 20.0, 0.0), max=(130.0, 100.0, 200.0), name="x", kind="no-fly zone", solid=False)
    lines = ground_lines(scenario(sky.Survey(FIELD, "mavic-3e", gsd=GSD), obstacles=(zone,)), 0)
    assert {gap.why for gap in lines.unseen} == {"no UAV may fly near enough because of no-fly zone 'x'"}
    assert all(shapely.Polygon(gap.outline).distance(shapely.Point(80, 60)) < 40 for gap in lines.unseen)


def test_lower_obstacles_are_flown_over():
    house = sky.Box(min=(30.0, 20.0, 0.0), max=(90.0, 60.0, 12.0))
    survey = sky.Survey(FIELD, "mavic-3e", gsd=GSD)
    plain, built = (ground_lines(scenario(survey, obstacles=obstacles), 0) for obstacles in ((), (house,)))
    assert len(built.lines) == len(plain.lines)
    assert not built.unseen


@pytest.mark.parametrize(("pattern", "headings"), [("cross", {None}), ("oblique", {None, 0.0, 90.0, 180.0, 270.0})])
def test_patterns_look_in_their_directions(pattern, headings):
    survey = sky.Survey(FIELD, "mavic-3e", gsd=GSD, pattern=pattern, direction=0.0)
    given = scenario(survey)
    lines = ground_lines(given, 0)
    assert {None if line.heading is None else round(line.heading) % 360.0 for line in lines.lines} == headings
    assert require_covered(given, lines) == 1.0
    for heading in headings - {None}:
        xy = places(asked_ground(survey), 4.0)
        slanting = [line for line in lines.lines if line.heading is not None and round(line.heading) % 360 == heading]
        assert np.any([in_picture(given, line, xy)[0].any(axis=0) for line in slanting], axis=0).all()


def test_a_corridor_is_seen_also_at_its_bends():
    line = ((0.0, 0.0), (90.0, 10.0), (120.0, 110.0), (220.0, 140.0))
    survey = sky.Survey(None, "mavic-3e", gsd=GSD, pattern="corridor", line=line, width=60.0)
    for heights in (None, relief(3, 15.0)):
        given = scenario(survey, heights)
        lines = ground_lines(given, 0)
        assert require_covered(given, lines) == 1.0
        assert not lines.unseen


@settings(max_examples=20, deadline=None)
@given(seed=st.integers(0, 100), overlap=st.sampled_from([(0, 0), (10, 0), (0, 10)]))
def test_over_relief_hardly_anything_is_unseen_where_no_overlap_is_asked_for(seed, overlap):
    given = scenario(sky.Survey(FIELD, "mavic-3e", gsd=GSD, overlap=overlap), relief(seed, 12.0))
    assert sum(gap.area for gap in ground_lines(given, 0).unseen) <= 0.005 * shapely.Polygon(FIELD).area


def test_a_height_is_kept_above_the_ground_below():
    survey = sky.Survey(FIELD, "mavic-3e", height=50.0, direction=0.0)
    given = scenario(survey, relief(5, 12.0), error={})
    for line in ground_lines(given, 0).lines:
        where, _ = photos(line)
        above = where[:, 2] - given.terrain.height(where[:, :2])
        assert above.max() <= 50.0 + 1e-6
        assert above.min() >= 0.8 * 50.0


def test_a_height_above_the_ceiling_is_refused_with_the_most_that_it_leaves():
    """What is told as the most is accepted, whatever the ceiling and the error."""
    for most, vertical in ((120.0, 3.0), (100.0, 0.26), (80.13, 1.0)):
        given = {"max_height": most, "error": {"horizontal": 1.0, "vertical": vertical}}
        with pytest.raises(sky.InputError, match="the ceiling leaves") as refused:
            ground_lines(scenario(sky.Survey(FIELD, "mavic-3e", height=500.0), relief(5, 12.0), **given), 0)
        left = float(re.search(r"expected ([\d.]+) m or less", str(refused.value))[1])
        assert most - vertical - 2.0 < left <= most - vertical
        assert ground_lines(scenario(sky.Survey(FIELD, "mavic-3e", height=left), relief(5, 12.0), **given), 0).lines


@pytest.mark.parametrize(
    ("field", "given"),
    [
        ("gimbal", {"gimbal": -20.0, "gsd": GSD}),
        ("area", {"area": ((0, 0), (1400.0, 0.0), (1400.0, 1300.0)), "gsd": 2e-3, "overlap": (80, 95)}),
        ("gsd", {"gsd": 2e-4}),
        ("height", {"height": 5000.0}),
        ("area", {"area": ((-400.0, -400.0), (-300.0, -400.0), (-300.0, -300.0)), "gsd": GSD}),
    ],
)
def test_what_cannot_be_flown_is_refused(field, given):
    survey = sky.Survey(**{"area": FIELD, "camera": "mavic-3e", **given})
    with pytest.raises(sky.InputError) as refused:
        ground_lines(scenario(survey, error={}), 0)
    assert refused.value.args[0].field == field
