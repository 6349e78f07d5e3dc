"""Surveys as planned: whatever the ground, wind, zones, UAVs and batteries, the referee finds nothing wrong."""

import math
import re
from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import skyverse as sky
from skyverse.survey import lines_of

SIDE, STEP, RISE = 240.0, 6.0, 20.0


def hills(rng, steep):
    """Return heights (n, n) of gentle waves about 0."""
    x, y = np.meshgrid(*(np.arange(0.0, SIDE + STEP, STEP),) * 2, indexing="ij")
    a, b = rng.uniform(0.0, 2 * np.pi, 2)
    return 8.0 * steep * (np.sin(x / rng.uniform(50, 90) + a) + np.cos(y / rng.uniform(50, 90) + b))


def random_survey(seed, drones, battery, steep, windy, zone):
    """Return a scenario with a survey of a small quadrangle."""
    rng = np.random.default_rng(seed)
    heights = hills(rng, steep)
    low, high = rng.uniform(40.0, 70.0, 4), rng.uniform(150.0, 200.0, 4)
    area = [(low[0], low[1]), (high[0], low[2]), (high[1], high[2]), (low[3], high[3])]
    uavs = []
    for i in range(drones):
        x, y = 30.0 + 12.0 * i, 24.0
        ground = float(heights[round(x / STEP), round(y / STEP)])
        uavs.append(
            sky.UAV(
                name=f"d{i}",
                start=(x, y, ground + RISE),
                end="home",
                max_speed=float(rng.uniform(8.0, 14.0)),
                max_acceleration=3.0,
                max_climb=4.0,
                max_descent=3.0,
                separation=float(rng.uniform(2.0, 5.0)),
                hover_power=400.0,
                mass=2.0,
                battery=battery,
                reserve=0.2,
            )
        )
    zones = ()
    if zone:
        centre = (float(rng.uniform(90, 150)), float(rng.uniform(90, 150)))
        zones = (sky.Cylinder(centre=centre, radius=12.0, low=-60.0, high=250.0, solid=False, kind="no-fly zone"),)
    return sky.Scenario(
        name="survey",
        bounds={"min": (0.0, 0.0, -60.0), "max": (SIDE, SIDE, 220.0)},
        clearance=3.0,
        terrain={"origin": (0.0, 0.0), "step": (STEP, STEP), "heights": heights, "clearance": 10.0},
        wind={"velocity": (3.0, 1.0, 0.0), "gust": 1.0} if windy else None,
        uavs=tuple(uavs),
        max_height=120.0,
        obstacles=zones,
        surveys=(sky.Survey(area, "mavic-3e", gsd="1.5 cm", overlap=(60, 40)),),
    )


@settings(max_examples=24, deadline=None)
@given(
    seed=st.integers(0, 10_000),
    drones=st.integers(1, 3),
    battery=st.sampled_from([None, 20.0, 30.0, 50.0]),
    steep=st.sampled_from([0.0, 0.5, 1.0]),
    windy=st.booleans(),
    zone=st.booleans(),
)
def test_the_referee_finds_nothing_wrong_with_planned_surveys(seed, drones, battery, steep, windy, zone):
    scenario = random_survey(seed, drones, battery, steep, windy, zone)
    mission = sky.plan_mission(scenario, options=sky.MissionOptions(criterion="min-max"))
    assert [one.message for one in mission.violations] == []
    if mission.unseen:  # by a zone, or since no battery gives what it takes
        return
    seen = mission.coverage[0].seen[0]
    assert seen > 0.9999
    flown = sum(len(sortie.strips) for own in mission.sorties for sortie in own)
    assert flown >= drones or battery is not None


@settings(max_examples=20, deadline=None)
@given(
    seed=st.integers(0, 10_000),
    steep=st.sampled_from([0.0, 0.4]),
    pattern=st.sampled_from(["strips", "cross", "oblique"]),
    gimbal=st.sampled_from([-45.0, -60.0, -75.0]),
)
def test_slanting_photos_show_all_finely_and_overlap_as_asked(seed, steep, pattern, gimbal):
    scenario = random_survey(seed, 1, None, steep, False, False)
    survey = scenario.surveys[0].model_copy(update={"pattern": pattern, "gimbal": gimbal})
    mission = sky.plan_mission(scenario.model_copy(update={"surveys": (survey,)}))
    assert [one.message for one in mission.violations] == []
    assert mission.coverage[0].verdict.value == "proven", mission.coverage[0].sentence


MAPPING = {"vehicle": "mapping"}
NIMBLE = {
    "fixed_wing": {"speed": 14.0, "turn_radius": 30.0, "climb": 10.0},
    "max_speed": 16.0,
    "max_acceleration": 12.0,
    "tracking_error": {"horizontal": 2.0, "vertical": 2.0},
}


def survey_by_aeroplane(seed, steepest, gsd_of, wing, most=250.0):
    """Return a scenario with a survey of a quadrangle on hills, some place of which is as steep as said, degrees."""
    rng = np.random.default_rng([seed, 37])
    x, heights = np.arange(61) * 15.0, np.zeros((61, 61))
    for _ in range(8):
        kx, ky = rng.normal(0.0, 2.0 * np.pi / 250.0, 2)
        heights += rng.normal() * np.sin(kx * x[:, None] + ky * x + rng.uniform(0.0, 6.3))
    heights *= math.tan(math.radians(steepest)) / np.hypot(*np.gradient(heights, 15.0)).max()
    heights -= heights.min()
    area = 450.0 + rng.uniform(-30, 30, (4, 2)) + rng.uniform(100, 200, (4, 2)) * [(-1, -1), (1, -1), (1, 1), (-1, 1)]
    start = (450.0, 150.0, float(heights[28:33, 8:13].max()) + 45.0)
    return sky.Scenario(
        name="hills",
        bounds={"min": (0.0, 0.0, 0.0), "max": (900.0, 900.0, float(heights.max()) + 400.0)},
        clearance=2.0,
        terrain={"origin": (0.0, 0.0), "step": (15.0, 15.0), "heights": heights, "clearance": 20.0},
        max_height=most,
        uavs=(sky.UAV(name="wing", start=start, end="home", **wing),),
        surveys=(sky.Survey(area.tolist(), "soda", gsd="3.5 cm", overlap=(70, 60), gsd_of=gsd_of),),
    )


def turned(mission):
    """Return by how many degrees at most the heading of a UAV changes from the first to the last photo of a strip."""
    most = 0.0
    for flight, sorties in zip(mission.trajectories, mission.sorties, strict=True):
        for strip in (strip for sortie in sorties for strip in sortie.strips):
            way = np.diff(flight.at(np.linspace(strip.begin, strip.end, 400)).position[:, :2], axis=0)
            most = max(most, float(np.ptp(np.unwrap(np.arctan2(way[:, 1], way[:, 0])))))
    return math.degrees(most)


@settings(max_examples=20, deadline=None)
@given(
    seed=st.integers(0, 10_000),
    steepest=st.sampled_from([8.0, 15.0, 25.0]),
    gsd_of=st.sampled_from(["photo", "place"]),
    wing=st.sampled_from([MAPPING, NIMBLE]),
)
def test_aeroplanes_fly_strips_over_hills_without_turning_and_photos_overlap_as_asked(seed, steepest, gsd_of, wing):
    mission = sky.plan_mission(survey_by_aeroplane(seed, steepest, gsd_of, wing))
    assert [one.message for one in mission.violations] == []
    assert mission.sorties[0][0].strips
    assert turned(mission) < 3.0
    assert mission.coverage[0].verdict.value == "proven", mission.coverage[0].sentence


def told_why(mission):
    """Return why strips are not flown, and parts not seen."""
    return {gap.why for gap in mission.unseen}


def test_a_ceiling_that_brings_photos_of_aeroplanes_too_near_to_each_other_is_told():
    scenario = survey_by_aeroplane(1, 15.0, "photo", MAPPING)
    low = scenario.model_copy(update={"max_height": 90.0})
    assert not told_why(sky.plan_mission(scenario))
    assert any(
        why.startswith("not flown: an aeroplane at 15 m/s flies 22.5 m from photo to photo, too far to overlap")
        and "as the ceiling of 90 m leaves 78.3 m above ground of the 159 m asked for" in why
        for why in told_why(sky.plan_mission(low))
    )


def test_ground_that_is_too_steep_for_aeroplanes_below_the_ceiling_is_told():
    scenario = survey_by_aeroplane(0, 40.0, "place", MAPPING, 60.0)
    survey = scenario.surveys[0].model_copy(update={"camera": sky.CAMERAS["sentera-65r"], "gsd": 0.01})
    unseen = lines_of(scenario.model_copy(update={"surveys": (survey,)}), 0).unseen
    why = "aeroplanes climb too gently to keep between its clearance and the ceiling of 60 m above it"
    assert sum(gap.area for gap in unseen if gap.why == why) > 50_000.0


@settings(max_examples=20, deadline=None)
@given(
    speed=st.floats(1.0, 4.6), blows_from=st.floats(0.0, 360.0), overlap=st.sampled_from([(60, 40), (50, 30), (20, 10)])
)
def test_noses_of_aeroplanes_point_into_the_wind_and_photos_overlap_as_asked(speed, blows_from, overlap):
    scenario = survey_by_aeroplane(0, 0.0, None, MAPPING)
    changes = {"overlap": overlap, "direction": 90.0}
    scenario = scenario.model_copy(
        update={
            "wind": sky.Wind(velocity=sky.wind_from(speed, blows_from)),
            "surveys": tuple(one.model_copy(update=changes) for one in scenario.surveys),
        }
    )
    mission = sky.plan_mission(scenario)
    photos = sky.photos_of(mission)
    air = mission.trajectory(0).at(photos.time).velocity[:, :2] - scenario.wind.velocity[:2]
    off = photos.heading - np.degrees(np.arctan2(*air.T))
    assert np.abs((off + 180.0) % 360.0 - 180.0).max() < 1.0
    assert [one.message for one in mission.violations] == []
    assert mission.coverage[0].verdict.value == "proven", mission.coverage[0].sentence


@settings(max_examples=20, deadline=None)
@given(
    bends=st.lists(st.tuples(st.floats(-70.0, 70.0), st.floats(8.0, 160.0)), min_size=1, max_size=6),
    width=st.sampled_from([30.0, 90.0]),
)
def test_aeroplanes_fly_along_a_line_with_bends_in_straight_strips_that_show_all_of_it(bends, width):
    turns = np.cumsum(np.radians([0.0, *(turn for turn, _ in bends)]))
    legs = np.array([160.0, *(long for _, long in bends)])[:, None] * np.column_stack([np.cos(turns), np.sin(turns)])
    line = np.vstack([np.zeros((1, 2)), np.cumsum(legs, axis=0)]) + 200.0
    line += 800.0 - 0.5 * (line.min(axis=0) + line.max(axis=0))
    mission = sky.plan_mission(
        sky.Scenario(
            name="road",
            clearance=2.0,
            bounds={"min": (0.0, 0.0, 0.0), "max": (1600.0, 1600.0, 400.0)},
            terrain={"origin": (0.0, 0.0), "step": (1600.0, 1600.0), "heights": np.zeros((2, 2)), "clearance": 20.0},
            uavs=(sky.UAV(name="wing", start=(800.0, 300.0, 100.0), end="home", **MAPPING),),
            surveys=(
                sky.Survey(
                    line=line.tolist(), camera="soda", width=width, pattern="corridor", gsd="3.5 cm", overlap=(70, 60)
                ),
            ),
        )
    )
    assert [one.message for one in mission.violations] == []
    assert turned(mission) < 3.0
    assert mission.coverage[0].gaps == (), mission.coverage[0].sentence


def test_a_survey_with_batteries_is_flown_in_sorties_that_they_give():
    scenario = random_survey(35, 1, 20.0, 1.0, False, False)
    mission = sky.plan_mission(scenario, options=sky.MissionOptions(criterion="min-max"))
    assert mission.violations == ()
    assert len(mission.sorties[0]) > 1


def test_a_strip_that_no_battery_reaches_is_told():
    scenario = random_survey(23, 1, 8.0, 0.0, False, False)
    mission = sky.plan_mission(scenario, options=sky.MissionOptions(criterion="min-max"))
    for gap in mission.unseen:
        length = sum(math.dist(a, b) for a, b in pairwise(gap.outline))
        long = float(re.fullmatch(r"not flown: no battery .* to fly along its (\S+) m, and to come back", gap.why)[1])
        assert long == pytest.approx(length, rel=0.05)
    assert mission.unseen
    assert mission.violations == ()
    assert not mission.seen


@settings(max_examples=20, deadline=None)
@given(
    seed=st.integers(0, 10_000), drones=st.integers(1, 2), steep=st.sampled_from([0.0, 0.5, 1.0]), zone=st.booleans()
)
def test_photos_at_points_are_flown_as_stops_whose_seconds_batteries_pay(seed, drones, steep, zone):
    scenario = random_survey(seed, drones, 50.0, steep, False, zone)
    survey = scenario.surveys[0].model_copy(update={"trigger": "point"})
    mission = sky.plan_mission(scenario.model_copy(update={"surveys": (survey,)}))
    assert [one.message for one in mission.violations] == []
    photos = sky.photos_of(mission)
    assert len(photos) > 5
    for uav, trajectory in enumerate(mission.trajectories):
        own = np.flatnonzero(photos.uav == uav)
        if trajectory is None:
            continue
        still = ~trajectory.coefficients[:, 1:].any(axis=(1, 2))
        stands, seconds = trajectory.coefficients[still, 0], np.diff(trajectory.knots)[still]
        for place in photos.position[own]:
            assert seconds[np.abs(stands - place).max(axis=1) < 1e-4].sum() >= 3.0 - 1e-9
        for strip in set(photos.strip[own].tolist()):  # where it stands, the top of a picture points ahead as well
            some = own[photos.strip[own] == strip]
            if len(some) > 2:
                assert np.ptp(np.unwrap(photos.heading[some], period=360.0)) < 1.0


def test_aeroplanes_take_no_photos_standing():
    scenario = survey_by_aeroplane(0, 8.0, "place", MAPPING)
    survey = scenario.surveys[0].model_copy(update={"trigger": "point"})
    with pytest.raises(sky.InputError, match="cannot stand still") as caught:
        sky.plan_mission(scenario.model_copy(update={"surveys": (survey,)}))
    assert caught.value.sentence.field == "trigger"
