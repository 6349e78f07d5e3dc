"""``skyverse repair`` writes nothing over what it reads, and tells what was changed in all, once."""

import json

import pytest

import skyverse as sky

HOME = sky.Origin(latitude=47.0, longitude=8.0, altitude=400.0)
LEVEL = ("--ground", "400 m amsl", "--vehicle", "camera", "--tracking-error", "1.6,3")


def place(x, y):
    return sky.to_wgs84(HOME, [[x, y, 0.0]])[0, :2].tolist()


def mission(path, *, height=30):
    items = [(22, [*place(0, 0), 30]), (16, [*place(0, 200), height]), (16, [*place(150, 200), 30])]
    made = [
        {"type": "SimpleItem", "command": command, "frame": 3, "params": [0, 0, 0, None, *numbers]}
        for command, numbers in items
    ]
    parts = {"items": made, "version": 2, "hoverSpeed": 5, "plannedHomePosition": [47.0, 8.0, 400.0]}
    path.parent.mkdir(exist_ok=True)
    path.write_text(json.dumps({"fileType": "Plan", "version": 1, "mission": parts | {"firmwareType": 12}}))
    return path


def test_what_was_changed_is_told_once_and_written(tmp_path, skyverse):
    source = mission(tmp_path / "m.plan", height=-20)
    code, out, _ = skyverse("repair", source, *LEVEL, "-o", tmp_path / "fixed.plan", "--page", tmp_path / "p.html")
    assert code == 0, out
    told = [line for line in out.splitlines() if line.startswith("  ")]
    assert len([line for line in told if line.startswith("  2: moved ")]) == 1
    assert "from -20.0 to" in out
    again = sky.read_waypoints(tmp_path / "fixed.plan")
    assert again.orders[1].place[2].metres > 2
    assert (tmp_path / "p.html").read_text().startswith("<!")
    code, out, _ = skyverse("repair", tmp_path / "fixed.plan", *LEVEL, "-o", tmp_path / "twice.plan")
    assert code == 0
    assert "no changes" in out
    assert (tmp_path / "twice.plan").read_bytes() == (tmp_path / "fixed.plan").read_bytes()


def test_what_is_proven_is_the_file_that_is_written_with_the_parameters_it_needs(tmp_path, skyverse):
    corners = [place(x, y) for x, y in ((65, 90), (85, 90), (85, 110), (65, 110), (65, 90))]
    tower = {"type": "Polygon", "coordinates": [[[longitude, latitude] for latitude, longitude in corners]]}
    shape = {"type": "Feature", "properties": {"height": 40}, "geometry": tower}
    towers, fixed, loaded = (tmp_path / name for name in ("towers.geojson", "fixed.plan", "fixed.params"))
    towers.write_text(json.dumps({"type": "FeatureCollection", "features": [shape]}))
    source, options = mission(tmp_path / "m.plan"), (*LEVEL, "--buildings", towers, "--unit", "m")
    assert skyverse("check", source, *options)[0] == 1
    code, out, _ = skyverse("repair", source, *options, "-o", fixed)
    assert (code, loaded.exists()) == (0, True)
    assert f"{fixed}: proven, with {loaded} loaded" in out.splitlines()
    assert out.splitlines()[-2:] == [str(fixed), str(loaded)]
    code, out, _ = skyverse("repair", source, *options, "-o", fixed, "--json")
    (told,) = json.loads(out)
    assert (told["written"], told["parameters"]) == (str(fixed), str(loaded))


@pytest.mark.parametrize(
    ("words", "kept"),
    [
        (("m.plan", "-o", "m.plan"), "m.plan"),
        (("m.plan", "-o", "q.plan", "--page", "q.plan"), "m.plan"),
        (("m.plan", "other/m.plan", "-o", "out"), "other/m.plan"),
        (("m.plan", "-o", "q.waypoints"), "m.plan"),
    ],
    ids=["onto itself", "page onto mission", "two of one name", "another format"],
)
def test_nothing_is_lost(tmp_path, refused, words, kept):
    for name in ("m.plan", "other/m.plan"):
        mission(tmp_path / name)
    before = (tmp_path / kept).read_bytes()
    files = [word if word.startswith("-") else tmp_path / word for word in words]
    refused("repair", *files[:1], *LEVEL, *files[1:])
    assert (tmp_path / kept).read_bytes() == before
    assert not (tmp_path / "q.plan").exists()


def test_options_that_a_scenario_has_are_refused_beside_it(tmp_path, refused):
    source = mission(tmp_path / "m.plan")
    refused("check", source, "--scenario", "jacksboro", "--clearance", "50")


def test_a_jump_that_leads_nowhere_for_ever_is_refused(tmp_path, refused):
    rows = ["0 1 0 16 0 0 0 0 47 8 400 1", "1 0 3 22 0 0 0 0 47 8 30 1", "2 0 2 177 3 -1 0 0 0 0 0 1"]
    rows += ["3 0 2 177 2 -1 0 0 0 0 0 1", "4 0 3 16 0 0 0 0 47.001 8 30 1"]
    path = tmp_path / "circle.waypoints"
    path.write_text("\n".join(["QGC WPL 110", *(row.replace(" ", "\t") for row in rows)]))
    refused("check", path, *LEVEL)
