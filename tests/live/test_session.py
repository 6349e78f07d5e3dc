"""What a steered mission answers: motions as data, refusals that change nothing, and messages that fit their schema."""

import json

import jsonschema
import numpy as np
import pytest

import skyverse as sky
from replanned import hall
from skyverse.live import LiveSession, live_schema

BALL = {"shape": "sphere", "centre": [0, 0, 0], "radius": 0.4}
SCHEMA = live_schema()


def session(scenario=None, **settings):
    return LiveSession(sky.Replanner(sky.plan_mission(scenario or hall())), **settings)


def told(message):
    """A message as it goes out, which fits the schema."""
    data = json.loads(message.model_dump_json())
    jsonschema.validate(data, SCHEMA)
    return data


def asked(live, number=1, **fields):
    """What is answered to an observation, which fits the schema too."""
    jsonschema.validate(fields, {**SCHEMA, "oneOf": [{"$ref": "#/$defs/ObservationMessage"}]})
    return told(live.answer(json.dumps(fields).encode(), number))


def seen(x, **more):
    return {"name": "ball", "shape": BALL, "position": [x, 5, 1], "top_speed": 2.0, **more}


def test_the_hello_says_who_flies_and_how_far_ahead_is_proven():
    live = session()
    hello = told(live.hello())
    assert hello["format"] == "skyverse/live/1"
    assert hello["uavs"] == [{"uav": 0, "name": "uav-1", "start": [1, 5, 1], "target": [19, 5, 1]}]
    assert hello["horizon"] == live.replanner.horizon
    assert hello["origin"] is None


def test_answers_hold_what_the_replanner_answers():
    live, twin = session(), sky.Replanner(sky.plan_mission(hall()))
    for k in range(20):
        t = k / 10
        (replan,) = twin.observe(t, movers=[seen(9.0 - t)])
        answer = asked(live, k + 1, t=t, movers=[seen(9.0 - t)])
        (uav,) = answer["uavs"]
        assert (answer["line"], answer["t"]) == (k + 1, t)
        for field in ("kept", "proven", "clear_until", "sentence"):
            assert uav[field] == getattr(replan, field)
        motion = sky.Trajectory(uav["motion"]["knots"], uav["motion"]["coefficients"])
        assert motion == sky.Trajectory(twin.motion(0).knots, twin.motion(0).coefficients)
        nose = uav["motion"]["yaw"]
        assert np.diff(nose["t"]).min(initial=1.0) > 0.0
        ahead = np.linspace(nose["t"][0], motion.end, 50)
        rates = np.interp(ahead, nose["t"], nose["yaw_rate"])
        yaw, rate, _ = twin.motion(0).heading(ahead)
        assert rates == pytest.approx(rate, abs=1e-9)
        turned = np.concatenate([[0.0], np.cumsum(0.5 * (rates[1:] + rates[:-1]) * np.diff(ahead))])
        assert nose["yaw"][0] + turned == pytest.approx(yaw, abs=0.02)
    assert live.summary().startswith("20 observations answered, ")


def test_setpoints_are_the_motion_sampled_up_to_the_horizon():
    live = session(setpoints=50)
    asked(live, t=0.0)
    (uav,) = asked(live, t=0.1)["uavs"]
    points, motion = uav["setpoints"], live.replanner.motion(0)
    assert points["t"][0] == 0.1
    assert np.diff(points["t"]) == pytest.approx(0.02)
    assert points["t"][-1] == pytest.approx(0.1 + live.replanner.horizon, abs=0.02)
    for name, rows in zip(("position", "velocity", "acceleration"), motion.at(points["t"]), strict=True):
        assert points[name] == rows.tolist()
    for name, row in zip(("yaw", "yaw_rate"), motion.heading(points["t"]), strict=False):
        assert points[name] == row.tolist()
    assert points["wgs84"] is None


def test_setpoints_in_degrees_are_where_the_motion_leads():
    origin = sky.Origin(latitude=47.0, longitude=8.0, altitude=400.0)
    live = session(sky.Scenario(**{**dict(hall()), "frame": sky.Frame(origin=origin)}), setpoints=10, wgs84=True)
    assert told(live.hello())["origin"]["latitude"] == 47.0
    (uav,) = asked(live, t=0.0)["uavs"]
    points = uav["setpoints"]
    assert sky.to_local(origin, points["wgs84"]) == pytest.approx(np.array(points["position"]), abs=1e-6)


def test_states_are_given_by_name_or_by_index():
    live = session()
    asked(live, t=0.0)
    for name, x in (("uav-1", 1.5), ("0", 2.0)):
        asked(live, t=0.1, states={name: {"position": [x, 5, 1], "velocity": [0, 0, 0]}})
        assert live.replanner.motion(0).at([0.1]).position[0] == pytest.approx([x, 5, 1])


def test_targets_and_zones_are_taken_in():
    live = session()
    asked(live, t=0.0)
    asked(live, t=0.1, targets={"uav-1": [5, 8, 2]}, zones=[{"min": [12, 0, 0], "max": [14, 10, 4], "max_speed": 0.5}])
    assert live.replanner.scenario.zones[0].max_speed == 0.5
    (uav,) = asked(live, t=0.2)["uavs"]
    for k in range(3, 80):
        (uav,) = asked(live, t=k / 10)["uavs"]
    assert uav["arrival"] < 7.9
    assert live.replanner.motion(0).at([uav["arrival"]]).position[0] == pytest.approx([5, 8, 2])


AT_ZERO = {"position": [0, 0, 0], "velocity": [0, 0, 0]}


@pytest.mark.parametrize(
    "text",
    [
        "nonsense",
        {"movers": [{}]},
        {"t": 1},
        {"targets": {"uav-1": [30, 5, 1]}},
        {"targets": {"uav-3": [3, 5, 1]}},
        {"obstacles": [{"min": [0, 0, 0], "max": [1, 1, -1]}]},
        {"states": {"uav-2": AT_ZERO}},
        {"states": {"uav-1": AT_ZERO, "0": AT_ZERO}},
    ],
)
def test_a_line_that_cannot_be_taken_is_refused_and_changes_nothing(text, says):
    live = session()

    def known():
        replanner = live.replanner
        return replanner.now, replanner.predicted(), replanner.motion(0), replanner.scenario

    asked(live, t=4.5, movers=[seen(12)])
    before = known()
    line = text if isinstance(text, str) else json.dumps({"t": 9, **text})
    error = told(live.answer(line.encode(), 7))["error"]
    assert error["line"] == 7
    says(error["message"])
    assert error["message"].startswith("expected JSON" if error["field"] is None else f"{error['field']}: ")
    assert before == known()
    assert live.refused == 1


def test_a_blank_line_has_no_answer():
    assert session().answer(b" \r", 1) is None


@pytest.mark.parametrize(
    "settings",
    [{"setpoints": 0.0}, {"setpoints": float("nan")}, {"wgs84": True}, {"wgs84": True, "setpoints": 1.0}],
)
def test_settings_that_cannot_be_are_refused(settings, refuses):
    with refuses():
        session(**settings)
