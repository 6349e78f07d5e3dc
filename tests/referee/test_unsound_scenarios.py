"""The referee judges by no scenario that could not be given, whoever made it, and however."""

import math
from dataclasses import replace

import pytest
from pydantic import BaseModel

import skyverse as sky
from every_part import EVERY_PART, numbers_in, unsound
from judged_missions import SCENARIO, VALID

PLACES = list(numbers_in(EVERY_PART))
NONE_FLY = replace(VALID, scenario=EVERY_PART, assignment=(None, None), results=(None, None), trajectories=(None, None))
WALL = sky.Box(min=(2, 2, 2), max=(3, 3, 3))
IMPOSSIBLE = {
    "a negative clearance": (("clearance",), -3.0),
    "a clearance in words": (("clearance",), "3"),
    "bounds turned round": (("bounds", "max"), (-1.0, 5.0, 5.0)),
    "no bounds": (("bounds",), None),
    "a negative separation": (("uavs", 0, "separation"), -1.0),
    "a separation of nought beside one above": (("uavs", 0, "separation"), 0.0),
    "a speed of nought": (("uavs", 0, "max_speed"), 0.0),
    "a negative acceleration": (("uavs", 1, "max_acceleration"), -1.0),
    "a jerk that no vehicle has": (("uavs", 0, "max_jerk"), 1e300),
    "a thrust that does not lift": (("uavs", 0, "thrust_to_weight"), 1.0),
    "a tilt beyond the horizontal": (("uavs", 0, "max_tilt"), 120.0),
    "a negative tracking error": (("uavs", 0, "tracking_error"), sky.TrackingError.model_construct(horizontal=-1.0)),
    "a home above the start": (("uavs", 0, "home"), 3.0),
    "an aeroplane faster than it may be": (("uavs", 1, "fixed_wing", "speed"), 9.0),
    "names that stand twice": (("uavs", 0, "name"), "uav-2"),
    "a UAV in words": (("uavs", 0), "uav-1"),
    "an obstacle turned inside out": (("obstacles", 0, "max"), (3.0, 3.0, 3.0)),
    "an obstacle that may be flown through": (("obstacles", 0, "risk"), 1.0),
    "a sphere of negative radius": (("obstacles", 2, "radius"), -1.0),
    "an outline that crosses itself": (("obstacles", 3, "vertices"), ((0, 0), (1, 1), (1, 0), (0, 1))),
    "an obstacle of no kind": (("obstacles", 0), object()),
    "an obstacle without a corner": (("obstacles", 0), sky.Box.model_construct(min=(0.0, 0.0, 0.0))),
    "ground with a hole": (("terrain", "heights"), EVERY_PART.terrain.heights * math.nan),
    "ground that does not cover the bounds": (("terrain", "step"), (1.0, 1.0)),
    "a ceiling below the clearance": (("max_height",), 0.1),
    "a zone with nothing to heed": (("zones", 0, "risk"), None),
    "a mover that is faster than it says": (("movers", 0, "motion", "times"), (0.0, 0.1)),
    "a doubt that shrinks": (("movers", 0, "doubt", "growth"), -0.1),
    "a lattice without steps": (("lattice", "step"), (0.0, 1.0, 1.0)),
    "a price below nought": (("objective", "fuel"), -1.0),
}  # fmt: skip


def refused(scenario, mission):
    """The field that every door of the referee names; each of them must refuse the scenario."""
    fields = set()
    for door in (sky.check, sky.certify):
        with pytest.raises(sky.InputError) as error:
            door(scenario, mission)
        fields.add(error.value.sentence.field)
    (field,) = fields
    return field


def spelt(place):
    return "".join(f"[{key}]" if isinstance(key, int) else f".{key}" for key in place)[1:]


def test_a_scenario_that_has_every_part_is_judged():
    known = {sky.Fault.ASSIGNMENT, sky.Fault.GIVEN, sky.Fault.VISIT, sky.Fault.STRIP}
    assert {violation.fault for violation in sky.check(EVERY_PART, NONE_FLY)} <= known
    assert len(PLACES) > 150


@pytest.mark.parametrize("value", [math.nan, math.inf, -math.inf])
def test_no_number_may_be_anything_but_finite(value):
    for place in PLACES:
        said = refused(unsound(EVERY_PART, place, value), NONE_FLY)
        assert spelt(place).startswith(said), (place, said)


@pytest.mark.parametrize(("place", "value"), IMPOSSIBLE.values(), ids=IMPOSSIBLE)
def test_what_no_scenario_may_be_is_refused(place, value):
    refused(unsound(EVERY_PART, place, value), NONE_FLY)


def test_a_negative_clearance_does_not_let_a_flight_through_a_wall_pass():
    through = BaseModel.model_copy(SCENARIO, update={"clearance": -3.0, "obstacles": (WALL,)})
    assert refused(through, replace(VALID, scenario=through)) == "clearance"
    with pytest.raises(sky.InputError, match="clearance"):
        sky.check_result(through, 0, 0, VALID.results[0])
    with pytest.raises(sky.InputError, match="clearance"):
        sky.plan_mission(BaseModel.model_copy(sky.read("map1"), update={"clearance": -3.0}))


def test_a_mission_that_embeds_an_unsound_scenario_is_another_one():
    for place, value in IMPOSSIBLE.values():
        embedded = replace(NONE_FLY, scenario=unsound(EVERY_PART, place, value))
        assert sky.Fault.SCENARIO in {violation.fault for violation in sky.check(EVERY_PART, embedded)}


@pytest.mark.parametrize("thing", ["map1", None, 3])
def test_what_is_no_scenario_is_refused(thing):
    assert refused(thing, VALID) == "scenario"
