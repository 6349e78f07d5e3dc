import dataclasses
import html.parser
import json
import re

import numpy as np
import pytest

import skyverse as sky
from browser import new_tab, opened, until
from skyverse.draw import footer, found, number, page, scene, slider_step
from skyverse.model.go_no_go import go_no_go
from towns import town

VOID = {"meta", "link", "input", "br", "img"}


class Reader(html.parser.HTMLParser):
    """Refuses tags that do not nest; gathers scripts, attributes and text."""

    def __init__(self):
        super().__init__()
        self.open, self.scripts, self.attributes, self.text = [], [], [], []

    def handle_starttag(self, tag, attrs):
        self.attributes += [(tag, *pair) for pair in attrs]
        if tag not in VOID:
            self.open.append(tag)
        if tag == "script":
            self.scripts.append("")

    def handle_endtag(self, tag):
        assert self.open, f"</{tag}> closes nothing"
        assert self.open.pop() == tag

    def handle_data(self, data):
        if self.open and self.open[-1] == "script":
            self.scripts[-1] += data
        elif self.open and self.open[-1] != "style":
            self.text.append(data)


def read(text):
    reader = Reader()
    reader.feed(text)
    reader.close()
    assert reader.open == []
    return reader


@pytest.mark.parametrize("case", ["mission", "troubled", "grounded", "swarm"])
def test_the_page_nests_and_loads_nothing_from_elsewhere(case, request):
    reader = read(page(scene(request.getfixturevalue(case))))
    assert len(reader.scripts) == 3
    for tag, name, value in reader.attributes:
        assert not name.startswith("on"), (tag, name)
        if name in ("src", "href", "srcset", "data", "action"):
            assert value == "data:," or value.startswith("#"), (tag, name, value)
    data = json.loads(reader.scripts[0])
    assert len(data["tracks"]) == len(request.getfixturevalue(case).scenario.uavs)
    assert "http" not in reader.scripts[2]
    policy = next(value for _, _, value in reader.attributes if value and value.startswith("default-src"))
    assert "http" not in policy


def test_a_mission_over_terrain_that_goes_nowhere_has_a_page():
    flown = town(3)
    start = flown.scenario.uavs[0].start
    up = (start[0], start[1], start[2] + 20)
    for target in (start, up):
        uav = sky.UAV(name="uav", start=start)
        bare = {"obstacles": (), "zones": (), "uavs": (uav,), "targets": (sky.Target(name="there", position=target),)}
        mission = sky.plan_mission(flown.scenario.model_copy(update=bare), sky.Taut(), rng=1)
        read(page(scene(mission)))


def test_strings_of_the_user_stay_text(troubled):
    text = page(scene(troubled))
    own = re.sub(r"(?s)<script>.*?</script>", "", text)
    for bite in ("<script>alert", "</script><script>", "<b>d</b>", "<i>0</i>", "<27>"):
        assert bite not in own
    reader = read(text)
    said = " ".join(reader.text)
    for name in (uav.name for uav in troubled.scenario.uavs):
        assert name in said
    assert 'alert("name")' in said
    data = json.loads(reader.scripts[0])
    assert [track["name"] for track in data["tracks"]] == [uav.name for uav in troubled.scenario.uavs]
    drawn = [trace.get("name", "") for trace in data["space"] + data["search"]]
    assert not any("<" in name for name in drawn)


def test_the_verdict_is_green_only_when_nothing_was_found(mission, troubled):
    good, bad = (found(scene(one))["banner"] for one in (proven(mission), troubled))
    assert "Go: all that was asked is proven." in good
    assert 'class="verdict good"' in good
    assert 'class="verdict bad"' in bad
    assert "No go: the referee found 2 things wrong and the run was interrupted." in bad
    assert 'data-time="3.25"' in bad
    assert 'class="verdict good"' not in bad + found(scene(mission))["banner"]  # there is no telling of the latter


def proven(mission):
    return dataclasses.replace(mission, apart=sky.Certificate(sky.Verdict.PROVEN, "All is proven."))


SEEN = sky.Coverage(0, sky.Verdict.PROVEN, "All is seen.", 9, 1.0, (1.0,), 0.1, 0.1, 0.1, (80.0, 70.0), 8, 0)


def surveyed(mission, coverage, **asked):
    camera = sky.Camera(name="test", sensor=(12.0, 9.0), image=(4000, 3000), focal=10.0, min_interval=1.0)
    field = {"name": "field", "camera": camera, "gsd": 0.03} | (asked or {"area": [(0, 0), (9, 0), (9, 9)]})
    uavs = tuple(uav.model_copy(update={"end": "home"}) for uav in mission.scenario.uavs)
    house = sky.Box(name="a", min=(0, 15, 0), max=(10, 20, 1))
    more = {"surveys": (sky.Survey(**field),), "uavs": uavs, "obstacles": (house,)}
    scenario = mission.scenario.model_copy(update=more)
    return dataclasses.replace(proven(mission), scenario=scenario, coverage=coverage)


@pytest.mark.parametrize(
    ("changed", "verdict", "told"),
    [
        (lambda one: one, "refuted", "is not photographed as asked"),
        (lambda one: dataclasses.replace(one, coverage=()), "undecided", "the photos of field are not proven"),
        (lambda one: surveyed(one, (SEEN,)), "proven", "Go: all that was asked is proven."),
        (lambda one: surveyed(one, (SEEN,), pattern="facade", structures=["a"]), "undecided", "Go, but how much"),
        (lambda one: dataclasses.replace(one, apart=None), "undecided", "has not been judged"),
        (lambda one: dataclasses.replace(one, apart=None), "refuted", "is not photographed as asked"),
        (lambda one: dataclasses.replace(one, results=(one.results[0], None)), "refuted", "no way to it"),
    ],
)
def test_one_verdict_is_of_the_flights_and_of_the_photos(mission, changed, verdict, told):
    refuted = surveyed(mission, (dataclasses.replace(SEEN, verdict=sky.Verdict.REFUTED),))
    judged = changed(refuted if verdict == "refuted" else surveyed(mission, (SEEN,)))
    one = go_no_go(judged)
    assert one.verdict.value == verdict
    assert told in one.sentence
    assert one.go == one.sentence.startswith("Go")
    assert one.sentence in found(scene(judged))["banner"]


def test_the_footer_says_what_made_the_answer_and_no_seed_of_a_planner_that_draws_none(mission):
    said = footer(scene(mission))
    for fact in ("walls", "MVO(universes=25)", "MaxIterations(4)", "Seed", "0.1.0"):
        assert fact in said
    said = footer(scene(sky.plan_mission(sky.read("map1"), sky.AStar(), rng=1)))
    assert "AStar()" in said
    assert "Seed" not in said
    assert "MaxIterations" not in said


def test_numbers_read_well():
    assert number(None) == "–"  # noqa: RUF001
    assert number(1234.5, 2) == "1,234.50"
    assert number(float("inf")) == "∞"


@pytest.mark.parametrize(("makespan", "step"), [(8.0, 0.05), (250.0, 1.0), (1.0, 0.005), (0.0, 1.0)])
def test_the_slider_steps_are_round(makespan, step):
    assert slider_step(makespan) == step


def test_a_missing_folder_is_an_error_and_leaves_nothing(mission, tmp_path, refuses):
    with refuses():
        sky.write_html(mission, tmp_path / "nowhere" / "page.html")
    sky.write_html(mission, tmp_path / "page.html")
    sky.write_html(mission, tmp_path / "page.html")
    assert [path.name for path in tmp_path.iterdir()] == ["page.html"]


# ---- in a browser ----
def opened_page(tab, mission, folder):
    """Write a mission's page and open it; return where it is."""
    target = folder / "page.html"
    sky.write_html(mission, target)
    opened(tab, target)
    return target


FLEET = """() => {
  const {x, y, z} = document.getElementById("space").data.at(-1);
  return x.map((_, uav) => [x[uav], y[uav], z[uav]]);
}"""


def test_the_fleet_flies_in_a_browser(mission, tmp_path, tab):
    target = opened_page(tab, mission, tmp_path)
    np.testing.assert_allclose(tab.evaluate(FLEET), [(5, -4, 3), (2, 19, 3)])

    slider = tab.get_by_role("slider", name="Time of flight in seconds")
    for t in (2.0, 3.0, 8.0):
        slider.fill(str(t))
        until(tab, f"document.getElementById('clock').textContent.startsWith('{t:.2f} s')")
        expected = [trajectory.at(t).position[0] for trajectory in mission.trajectories]
        until(tab, FLEET, lambda places: np.allclose(places, expected, atol=0.01))  # noqa: B023

    slider.fill("1")
    slider.press("ArrowRight")
    assert tab.locator("#clock").text_content().startswith("1.05 s")

    tab.get_by_role("button", name="Play").click()
    until(tab, "document.getElementById('time').value > 1.3")
    tab.get_by_role("button", name="Pause").click()
    assert tab.evaluate(FLEET)[0] != [5, -4, 3]

    tab.get_by_role("button", name="ben").click()
    until(tab, "document.getElementById('space').data.at(-1).x[1] === null")
    tab.get_by_role("button", name="Generated paths").click()
    until(tab, "document.getElementById('search').data[1].x[0] === 25")

    assert tab.errors == []
    assert tab.requests == [target.as_uri()]


READOUT = """() => {
  const map = document.getElementById("map"), box = map.getBoundingClientRect(), plane = internals.plane(map);
  const [right, down] = plane.pixel(250, 750);
  const clientX = box.left + plane.left + right, clientY = box.top + plane.top + down;
  map.dispatchEvent(new MouseEvent("mousemove", {clientX, clientY, bubbles: true}));
  return document.getElementById("where").textContent;
}"""


def test_map_and_profile_are_drawn_in_a_browser(tmp_path, tab):
    mission = town(60)
    target = opened_page(tab, mission, tmp_path)
    drawn = scene(mission)

    told = tab.evaluate(READOUT)
    x, y, latitude, longitude, height = (float(word) for word in re.findall(r"\d+\.?\d*", told.replace(",", "")))
    np.testing.assert_allclose((x, y), (250, 750), atol=5)  # a pixel is some metres wide
    there = sky.to_wgs84(mission.scenario.frame.origin, [(x, y, mission.scenario.terrain.height((x, y)))])[0]
    np.testing.assert_allclose((latitude, longitude), there[:2], atol=2e-5)
    assert told.endswith(" m above sea level")
    assert height == pytest.approx(there[2], abs=1.5)

    side = "document.getElementById('profile').data.find((t) => t.meta.role === 'flight')"
    assert tab.evaluate(f"{side}.name") == "uav-1"
    tab.get_by_label("UAV of the profile").select_option("uav-2")
    until(tab, f"{side}.name === 'uav-2'")
    shown = tab.evaluate(
        "Array.from(document.getElementById('profile')._fullData.find((t) => t.meta.role === 'flight').y)"
    )
    np.testing.assert_allclose(shown, drawn.profiles[1].points[:, 2], atol=0.01)

    tab.get_by_label("building (60)").click()
    role = "(t) => t.meta.role === 'kind' && t.name === 'building'"
    until(tab, f"document.getElementById('map').data.find({role}).visible === false")
    assert tab.evaluate(f"document.getElementById('space').data.find({role}).visible") is False
    assert tab.errors == []
    assert tab.requests == [target.as_uri()]


@pytest.fixture(scope="module")
def town_tab(browser, tmp_path_factory):
    """A large tab with the page of a small town, which no test changes."""
    with new_tab(browser, 1400, 1600) as tab:
        opened_page(tab, town(5), tmp_path_factory.mktemp("town"))
        yield tab


@pytest.mark.parametrize("chart", ["map", "profile"])
def test_the_words_below_a_chart_are_not_written_over_its_axis(town_tab, chart):
    title = f"document.querySelector('#{chart} .xtitle').getBoundingClientRect()"
    words = f"document.getElementById('{'mapped' if chart == 'map' else 'sideways'}').getBoundingClientRect()"
    assert town_tab.evaluate(f"{title}.height") > 0
    until(town_tab, f"{title}.bottom <= {words}.top + 1")


def test_plotly_still_has_the_private_interfaces_that_the_page_uses(town_tab):
    for chart in ("map", "profile"):
        assert town_tab.evaluate(f"internals.plane(document.getElementById('{chart}')) !== null")
    assert town_tab.evaluate("internals.space(document.getElementById('space')) !== null")
    assert town_tab.evaluate("internals.update(document.getElementById('space'), [])")


def test_without_plotlys_private_interfaces_the_page_is_drawn_without_marks_on_the_map(tmp_path, tab):
    mission = town(5)
    target = tmp_path / "page.html"
    sky.write_html(mission, target)
    text = target.read_text("utf-8")
    target.write_text(text.replace("return { plane, space,", "return { plane: () => null, space: () => null,"), "utf-8")
    opened(tab, target)
    tab.get_by_role("slider", name="Time of flight in seconds").fill("30")
    until(tab, "document.getElementById('clock').textContent.startsWith('30')")
    assert tab.evaluate("[...document.querySelectorAll('#map b.uav')].every((mark) => mark.hidden)")
    assert tab.errors == []


SCENE = "internals.space(document.getElementById('space'))"
QUICK = f"{SCENE}.glplot.objects.filter((object) => Object.hasOwn(object, 'drawPick')).length"


@pytest.fixture(scope="module")
def flown(browser, tmp_path_factory):
    """A mission and a tab with its page, for tests that need not be the first to change it."""
    mission = town(20)
    with new_tab(browser) as tab:
        opened_page(tab, mission, tmp_path_factory.mktemp("town"))
        yield mission, tab


def test_what_is_below_the_pointer_is_not_looked_for_while_the_picture_is_turned(flown):
    _, tab = flown
    objects = tab.evaluate(f"{SCENE}.glplot.objects.length")
    assert tab.evaluate(QUICK) == 0
    box = tab.locator("#space").bounding_box()
    x, y = box["x"] + box["width"] / 2, box["y"] + box["height"] / 2
    before = tab.evaluate(f"{SCENE}.getCamera().eye.x")
    tab.mouse.move(x, y)
    tab.mouse.down()
    tab.mouse.move(x + 60, y)
    assert tab.evaluate(QUICK) >= objects  # and perhaps a coarser ground
    tab.mouse.up()
    until(tab, f"{QUICK} === 0")
    assert tab.evaluate(f"{SCENE}.glplot.objects.length") == objects
    assert tab.evaluate(f"{SCENE}.glplot.pixelRatio") == 2
    assert tab.evaluate(f"{SCENE}.getCamera().eye.x") != before
    assert tab.errors == []


def test_uavs_move_without_anything_else_being_laid_out_anew(flown):
    mission, tab = flown
    tab.evaluate("""() => {
      window.laid = 0;
      document.getElementById("space").on("plotly_afterplot", () => { window.laid += 1; });
    }""")
    tab.get_by_role("slider", name="Time of flight in seconds").fill("30")
    until(tab, "document.getElementById('clock').textContent.startsWith('30')")
    expected = [trajectory.at(30.0).position[0] for trajectory in mission.trajectories]
    np.testing.assert_allclose(tab.evaluate(FLEET), expected, atol=0.01)
    # what is drawn, not what was asked for: in shares of the picture, as plotly scales them
    drawn = f"""() => {{
      const host = document.getElementById("space"), scene = {SCENE};
      return scene.traces[host._fullData.at(-1).uid].dataPoints.map((p) => p.map((v, k) => v / scene.dataScale[k]));
    }}"""
    np.testing.assert_allclose(tab.evaluate(drawn), expected, atol=0.01)
    assert tab.evaluate("window.laid") == 0
    assert tab.errors == []


def test_uavs_move_by_plotlys_own_way_where_its_scene_is_not_as_it_was(tmp_path, tab):
    mission = town(5)
    opened_page(tab, mission, tmp_path)
    tab.evaluate(f"""() => {{
      const host = document.getElementById("space");
      delete {SCENE}.traces[host._fullData.at(-1).uid];
      window.laid = 0;
      host.on("plotly_afterplot", () => {{ window.laid += 1; }});
    }}""")
    tab.get_by_role("slider", name="Time of flight in seconds").fill("30")
    until(tab, "window.laid > 0")
    expected = [trajectory.at(30.0).position[0] for trajectory in mission.trajectories]
    np.testing.assert_allclose(tab.evaluate(FLEET), expected, atol=0.01)
    assert tab.errors == []


def test_the_page_of_a_mission_that_was_read_says_that_nobody_judged_it(tmp_path):
    sky.write(sky.plan_mission(sky.read("map1"), sky.Taut()), tmp_path / "m.json")
    said = found(scene(sky.read_mission(tmp_path / "m.json")))["banner"]
    assert "No go: the mission has not been judged." in said
    assert "found nothing wrong" not in said


def test_a_page_says_that_all_is_proven_only_where_it_is():
    mission = sky.plan_mission(sky.read("map1"), sky.Taut())
    assert "Proven at every instant: clear of obstacles, in bounds" in found(scene(mission))["banner"]
    assert "Proven at every instant" not in found(scene(dataclasses.replace(mission, apart=None)))["banner"]
