"""What pictures of replanned flights show, as data: what was held, committed to and seen at each instant."""

import json
import re

import numpy as np
import pytest

import skyverse as sky
from browser import fits, until
from replanned import BALL, hall
from skyverse.draw import TICKS, ReplannedScene, replanned_frames, replanned_page, still

pytest.importorskip("rotorpy", reason='rotorpy is not installed; pip install "skyverse[flight]"')

CROSSING = sky.Mover(
    name="<cart>", shape=BALL, motion=sky.WaypointMotion(points=[(5, 2, 1), (5, 8, 1)], times=[0, 6], then="returns")
)
WALL = sky.Box(min=(5, 1.5, 0), max=(5.4, 8, 4))


@pytest.fixture(scope="module")
def drawn():
    """A flight of 2.5 s past a mover and a wall that the mission does not know of."""
    known = hall(size=(10, 10, 4), targets=[sky.Target(position=(9, 5, 1))])
    truth = sky.Scenario(**{**dict(known), "movers": [CROSSING], "obstacles": [WALL]})
    sensor = sky.Sensor(range=3.9, delay=0.05, error=0.02)
    replanner = sky.Replanner(sky.plan_mission(known))
    return ReplannedScene(sky.fly_replanned(replanner, truth, sensor, rng=4, longest=2.5))


def test_what_is_committed_to_begins_where_the_command_is_and_ends_at_rest(drawn):
    (reference,), (ways,) = drawn.flight.references, drawn.committed
    assert len(ways) > 3
    for way in ways:
        assert way.places[0] == pytest.approx(reference.at([way.times[0]]).position[0], abs=1e-9)
        ahead, out = way.ahead(way.since)
        assert ahead[0] == pytest.approx(reference.at([way.since]).position[0], abs=1e-3)
        assert ahead[-1] == pytest.approx(out[0])
        assert out[-1] == pytest.approx(way.places[-1])


def test_the_way_out_only_brakes(drawn):
    for way in drawn.committed[0]:
        on = way.times >= way.brakes - 1e-9
        steps = np.linalg.norm(np.diff(way.places[on], axis=0), axis=1)
        assert (np.diff(steps[:-1]) <= 1e-6).all()


def test_predictions_at_an_instant_are_those_of_the_last_observation_that_has_arrived(drawn):
    steps = drawn.flight.steps
    k = next(k for k, step in enumerate(steps) if step.predictions)
    assert drawn.predicted(steps[k].arrival - 0.01) == []
    ((mover, place, doubt),) = drawn.predicted(steps[k].arrival, 0.5)
    later = steps[k].arrival + 0.5
    assert mover.name == "<cart>"
    assert np.linalg.norm(place - CROSSING.at([later])[0]) <= doubt


def test_an_unknown_obstacle_is_no_part_of_the_known_world_and_is_seen_when_it_was(drawn):
    assert drawn.scene.world.kinds == ()
    assert drawn.unknown == (WALL,)
    assert drawn.seen == tuple(step.arrival for step in drawn.flight.steps if step.obstacles)


def test_every_answer_has_a_mark_on_the_time_line(drawn):
    (ticks,) = drawn.ticks
    for (when, tick), step in zip(ticks, drawn.flight.steps, strict=True):
        (answer,) = step.answers
        assert when == step.arrival
        assert tick == ("no way out" if not answer.proven else "kept" if answer.kept else "replaced")


def test_the_page_has_what_its_scripts_move_and_escapes_names(drawn):
    page = replanned_page(drawn.flight)
    assert "<cart>" not in page
    data = json.loads(re.search(r'<script type="application/json" id="mission">(.*?)</script>', page, re.S)[1])
    replans = data["replans"]
    steps = drawn.flight.steps
    assert len(replans["arrivals"]) == len(replans["predictions"]) == len(replans["ticks"][0]) == len(steps)
    assert set(replans["ticks"][0]) <= set("krn")
    assert replans["seen"] == list(drawn.seen)
    k = next(k for k, step in enumerate(steps) if step.predictions)
    number, since, *numbers, radius, growth, acceleration, lasts = replans["predictions"][k][0]
    predicted = steps[k].predictions[0]
    assert (number, since, radius) == (0, pytest.approx(steps[k].time), pytest.approx(0.02))
    assert growth == pytest.approx(predicted.doubt.growth, abs=1e-4)
    assert acceleration == pytest.approx(predicted.doubt.acceleration, abs=1e-4)
    assert lasts == pytest.approx(predicted.doubt.accelerating_for if acceleration else 0.0, abs=1e-3)
    place = np.array(numbers[:3]) + 0.4 * np.array(numbers[3:])
    assert place == pytest.approx(predicted.motion.at([since + 0.4])[0], abs=1e-3)
    roles = [trace["meta"]["role"] for trace in data["space"]]
    assert {"committed", "out", "doubt", "sensor", "planned", "ghost", "unknown"} <= set(roles)
    assert roles[-2:] == ["trail", "fleet"]


def test_a_flight_among_plain_boxes_without_movers_has_a_page_and_figures():
    known = hall(size=(10, 10, 4), targets=[sky.Target(position=(9, 5, 1))])
    truth = sky.Scenario(**{**dict(known), "obstacles": [WALL]})
    flight = sky.fly_replanned(sky.Replanner(sky.plan_mission(known)), truth, sky.Sensor(range=1.0), longest=0.3)
    page = replanned_page(flight)
    assert "uav-1 has not arrived when the flight ends at 0.30 s" in page
    told = [text.get_text() for text in still(ReplannedScene(flight), 0.2).legends[0].get_texts()]
    assert "obstacle not seen yet" in told
    assert "mover" not in told


def test_a_film_shows_the_wall_once_it_is_seen_and_every_answer_in_its_colour(drawn):
    before, after = replanned_frames(drawn, [0.0, 2.4], 1, 60)
    assert before.shape == after.shape
    assert not any(size % 2 for size in before.shape[:2])
    replaced = np.array([int(TICKS["replaced"][k : k + 2], 16) for k in (1, 3, 5)])
    counts = [(np.abs(frame.astype(int) - replaced).max(axis=2) < 40).sum() for frame in (before, after)]
    assert counts[1] > counts[0]
    figure = still(drawn, 2.4)
    walls = [patch for patch in figure.axes[-1].patches if patch.get_linestyle() in ("-", "solid")]
    assert walls
    told = [text.get_text() for text in figure.texts]
    assert f"{drawn.scene.makespan:.2f} s" in told[1]
    assert told[2].startswith("uav-1 has")


def test_animations_and_instants_are_written_whole(drawn, tmp_path, monkeypatch):
    image = pytest.importorskip("PIL.Image")
    from skyverse.draw import animation

    monkeypatch.setattr(animation, "instants", lambda scene: ([0.0, 1.0, 2.0], 1))
    sky.write_animation(drawn.flight, tmp_path / "film.gif")
    with image.open(tmp_path / "film.gif") as film:
        assert film.n_frames == 3
    written = sky.write_instants(drawn.flight, tmp_path)
    assert [path.name for path in written] == ["flown-initial.png", "flown-middle.png", "flown-final.png"]


SHOWN = """() => Object.fromEntries(document.getElementById("space").data.map(({meta, x, y, z, visible}) => {
  const point = (k) => (Array.isArray(x) ? [x, y, z].map((values) => values.at(k)) : null);
  return [meta.role, {first: point(0), last: point(-2), visible}];
}))"""


def becomes(tab, role, field, expected):
    """Wait until what a trace shows is as expected."""
    return until(tab, SHOWN, lambda shown: shown[role][field] == expected)


def test_committed_ways_doubt_and_unknown_obstacles_move_in_a_browser(drawn, tmp_path, tab):
    target = tmp_path / "page.html"
    sky.write_animation(drawn.flight, target)
    fits(tab, target)
    (wall_seen,) = drawn.seen
    slider = tab.get_by_role("slider", name="Time of flight in seconds")
    becomes(tab, "unknown", "visible", wall_seen <= 0.0)
    slider.fill("2.2")
    ahead, out = drawn.way(0, 2.2).ahead(2.2)
    becomes(tab, "unknown", "visible", True)
    shown = becomes(tab, "committed", "first", pytest.approx(ahead[0], abs=0.01))
    assert shown["out"]["first"] == pytest.approx(out[0], abs=0.05)
    assert shown["out"]["last"] == pytest.approx(out[-1], abs=0.01)
    map_shapes = tab.evaluate("[...document.querySelectorAll('.replans path')].map((path) => path.className.baseVal)")
    held = 3 * len(drawn.predicted(2.2))
    assert map_shapes.count("held") == held > 0
    assert {"wall", "sensor", "flown", "planned", "out"} <= set(map_shapes)
    assert tab.locator(".answers output").text_content() == drawn.flight.steps[21].answers[0].sentence
    assert tab.locator(".answers path:not(.cursor)").count() == len(drawn.flight.steps)
    tab.get_by_label("Where movers may be").uncheck()
    becomes(tab, "doubt", "visible", False)
    assert tab.locator(".replans .held").count() == 0
    box = tab.locator(".answers svg").bounding_box()
    tab.mouse.click(box["x"] + box["width"] / 2, box["y"] + 3)
    half = pytest.approx(drawn.scene.makespan / 2, abs=0.02)
    until(tab, "parseFloat(document.getElementById('clock').textContent)", lambda seconds: seconds == half)
    assert tab.errors == []
