"""Files that are no missions, hold what nobody may guess, or are made to do harm: each gets one clear sentence."""

import io
import json
import re
import zipfile
from dataclasses import replace

import pytest
from hypothesis import given as drawn
from hypothesis import settings
from hypothesis import strategies as st

import skyverse as sky
import written_missions as given
from skyverse.model.altitude import AboveSea
from skyverse.model.waypoints import Order
from skyverse.model.waypoints import OrderKind as Kind


def of_plan(**more):
    """A plan whose mission has other values."""
    plan = json.loads(given.plan(given.FLIGHT))
    plan["mission"] |= more
    return json.dumps(plan)


def one(*numbers, **how):
    return given.plan([given.item(*numbers, **how)])


def with_row(row):
    return given.WPL + f"7\t0\t3\t{row}\t1\n"


def bomb():
    made = io.BytesIO()
    with zipfile.ZipFile(made, "w", zipfile.ZIP_DEFLATED) as archive:
        archive.writestr("wpmz/waylines.wpml", bytes(300_000_000))
    return made.getvalue()


def flown_twice():
    text = given.waylines()
    begin, end = text.index("    <Folder>"), text.index("  </Document>")
    return given.kmz(wpmz__waylines_wpml=text[:end] + text[begin:end] + text[end:])


STRUCTURE = {"type": "ComplexItem", "complexItemType": "StructureScan", "Altitude": 30, "version": 3}
LANDING = {"type": "ComplexItem", "complexItemType": "fwLandingPattern", "landCoordinate": [47.0, 8.0, 0], "version": 2}
FENCE_1 = {"polygon": [[47.0, 8.0], [47.0, 8.1], [47.1, 8.1]], "version": 1}
ROWS_OF_A_FENCE = "\n".join([*given.WPL.splitlines()[:2], "1 0 3 5001 3 0 0 0 47.0 8.0 100 1", ""])
REFUSED = {
    "an old mission.plan": json.dumps({"MAV_AUTOPILOT": 12, "items": [], "version": 1}),
    "no json.plan": "QGC WPL 110\n",
    "deep.plan": "[" * 5000,
    "a version.plan": of_plan(version=1),
    "no items.plan": of_plan(items={"a": 1}),
    "speed.plan": of_plan(hoverSpeed=-3),
    "a rover.plan": of_plan(vehicleType=10),
    "a submarine.plan": of_plan(vehicleType=12),
    "an airship.plan": of_plan(vehicleType=7),
    "a firmware.plan": of_plan(firmwareType={"a": 1}),
    "home.plan": of_plan(plannedHomePosition=[147.0, 8.0, 0]),
    "a structure.plan": given.plan([STRUCTURE]),
    "an older landing pattern.plan": given.plan([LANDING]),
    "no item.plan": given.plan([17]),
    "a kind.plan": given.plan([{"type": "Something"}]),
    "an old fence.plan": given.plan(given.FLIGHT, geoFence=FENCE_1),
    "a fence.plan": given.plan(given.FLIGHT, geoFence={"circles": [], "polygons": [{"polygon": []}], "version": 2}),
    "seven.plan": one(16, 0, 0, 0),
    "a hold.plan": one(16, -5, 0, 0, 0, 47, 8, 30),
    "a huge number.plan": one(16, 1e300, 0, 0, 0, 47, 8, 30),
    "infinity.plan": one(16, 0, 0, 0, 0, 47, 8, float("inf")),
    "no altitude.plan": one(16, 0, 0, 0, 0, 47, 8, None),
    "swapped.plan": one(16, 0, 0, 0, 0, 147.0, 8.0, 30),
    "a local frame.plan": one(16, 0, 0, 0, 0, 47, 8, 30, frame=1),
    "a command.plan": given.plan([given.item(16, 0, 0, 0, 0, 47, 8, 30) | {"command": "16"}]),
    "a negative frame.plan": one(16, 0, 0, 0, 0, 47, 8, 30, frame=-1),
    "half a command.plan": one(16.5, 0, 0, 0, 0, 47, 8, 30),
    "a tag.plan": one(601, 99, 1, 0, 0, 0, 0, 0, frame=2),
    "a jump.plan": one(177, 99, 1, 0, 0, 0, 0, 0, frame=2),
    "half a jump.plan": one(177, 1, 1.5, 0, 0, 0, 0, 0, frame=2),
    "parameters.txt": "#NOTE: 1\nWPNAV_SPEED,500\nRTL_ALT,1500\n",
    "a fence.txt": "47.0 8.0\n47.1 8.1\n",
    "a fence.waypoints": ROWS_OF_A_FENCE,
    "an older version.txt": given.WPL.replace("110", "100"),
    "no home.txt": given.WPL.replace("\n0\t1", "\n1\t1"),
    "takes off at once.txt": given.WPL.replace("\t0\t16\t", "\t0\t22\t", 1),
    "rally points.txt": ROWS_OF_A_FENCE.replace("5001", "5100"),
    "eleven.txt": given.WPL.replace("\t30\t1", "\t1"),
    "words.txt": with_row("sixteen\t0\t0\t0\t0\t47\t8\t30"),
    "a jump.txt": with_row("177\t12\t1\t0\t0\t0\t0\t0"),
    "nan.txt": with_row("16\t0\t0\t0\t0\t47\t8\tnan"),
    "latin.txt": given.WPL.encode() + b"\xff\xfe",
    "empty.waypoints": "",
    "no archive.kmz": "PK but no archive",
    "cut.kmz": given.dji()[:200],
    "a bomb.kmz": bomb(),
    "nothing in it.kmz": given.kmz(readme_txt="hello"),
    "broken xml.kmz": given.kmz(wpmz__waylines_wpml=given.waylines()[:400]),
    "entities.kmz": given.kmz(wpmz__waylines_wpml='<!DOCTYPE a [<!ENTITY b "c">]><kml>&b;</kml>'),
    "two waylines.kmz": flown_twice(),
    "no waypoints.kmz": given.kmz(wpmz__waylines_wpml=given.dji_document(given.dji_config(), "<Folder></Folder>")),
    "mapping.kmz": given.kmz(wpmz__template_kml=given.template(kind="mapping2d")),
    "the ellipsoid.kmz": given.kmz(wpmz__waylines_wpml=given.waylines("WGS84")),
    "a height mode.kmz": given.kmz(wpmz__waylines_wpml=given.waylines("aboveMoon")),
    "an index.kmz": given.kmz(wpmz__waylines_wpml=given.waylines().replace("index>2<", "index>7<")),
    "a group.kmz": given.kmz(wpmz__waylines_wpml=given.waylines().replace("EndIndex>3<", "EndIndex>9<")),
    "a word.kmz": given.kmz(wpmz__waylines_wpml=given.waylines().replace(">52.5<", ">high<")),
    "a hover.kmz": given.kmz(wpmz__waylines_wpml=given.waylines().replace("hoverTime>4", "hoverTime>-4")),
    "no litchi.csv": "time,x,y,z\n0,1,2,3\n",
    "semicolons.csv": given.litchi().replace(",", ";"),
    "no unit.csv": given.litchi().replace("altitude(m)", "altitude", 1),
    "a unit.csv": given.litchi().replace("altitude(m)", "altitude(yd)", 1),
    "no rows.csv": given.litchi([]),
    "short.csv": given.litchi() + "47,8,30\r\n",
    "a mode.csv": given.litchi([given.litchi_row(47, 8, 30, altitudemode=7)]),
    "no mode.csv": given.litchi([given.litchi_row(47, 8, 30, altitudemode="")]),
    "a stay.csv": given.litchi([given.litchi_row(47, 8, 30, [(0, -1)])]),
    "a place without height.csv": given.litchi().replace("poi_altitude(m)", "poi_height(m)"),
    "a take-off.kmz": given.kmz(
        wpmz__waylines_wpml=given.waylines(), wpmz__template_kml=given.template(takeOffRefPoint="here,8.0,400")
    ),
    "two lines.kml": given.kml(*(given.kml_mark(name, "LineString", "8,47,3 8,48,3", "absolute") for name in "ab")),
    "an area.kml": given.kml("<Placemark><Polygon/></Placemark>"),
    "on the ground.kml": given.kml(given.kml_mark("a", "LineString", "8,47,3 8,48,3", "clampToGround")),
    "below the sea.kml": given.kml(given.kml_mark("a", "LineString", "8,47,3 8,48,3", "clampToSeaFloor")),
    "flat.kml": given.kml(given.kml_mark("a", "LineString", "8,47 8,48", "absolute")),
    "swapped.kml": given.kml(given.kml_mark("a", "Point", "8,147,3", "absolute")),
    "no reference.gpx": given.GPX,
    "two routes.gpx": given.GPX.replace("</gpx>", "<trk><name>b</name></trk></gpx>"),
    "no route.gpx": '<gpx version="1.1"></gpx>',
    "something else.gpx": "<kml></kml>",
    "no ending": given.WPL,
    "other.yaml": given.WPL,
}


@pytest.mark.parametrize("name", REFUSED)
def test_what_cannot_be_read_as_it_is_meant_is_refused(tmp_path, name, refuses):
    path = given.write(tmp_path / name, REFUSED[name])
    with refuses():
        sky.read_waypoints(path)


def test_options_that_cannot_be_are_refused(tmp_path, refuses):
    path = given.write(tmp_path / "m.gpx", given.GPX)
    with refuses():
        sky.read_waypoints(path, altitude="feet")
    with refuses():
        sky.read_waypoints(path, altitude="amsl", geoid=400.0)
    with refuses():
        sky.read_waypoints(tmp_path / "none.gpx", altitude="amsl")


def test_changes_that_a_file_cannot_hold_are_refused(tmp_path, refuses):
    told = sky.read_waypoints(given.write(tmp_path / "m.wpml.kmz", given.dji()))
    first = next(k for k, order in enumerate(told.orders) if order.kind is Kind.WAYPOINT)

    def put(k, order):
        return replace(told, orders=(*told.orders[:k], *order, *told.orders[k + 1 :]))

    order = told.orders[first]
    with refuses():
        sky.write_waypoints(put(first, []), tmp_path / "o.kmz")
    with refuses():
        sky.write_waypoints(put(first, [replace(order, place=(*order.place[:2], AboveSea(400.0)))]), tmp_path / "o.kmz")
    back = len(told.orders) - 1
    with refuses():
        sky.write_waypoints(put(back, [replace(told.orders[back], place=order.place)]), tmp_path / "o.kmz")
    with refuses():
        sky.write_waypoints(told, tmp_path / "o.plan")
    assert not (tmp_path / "o.kmz").exists()


VALUES = re.compile(r"(?<=[>\",\t: \[])[^<>\",\t\r\n\]\[ ]+(?=[<\",\t\r\n\] ])")
WRONG = ["", "x", "-1", "1e999", "nan", "99999999999", "0.5", "null", "[]", "{}", "true", "\u00e9", "-0", "1_0"]


def wrong_somewhere(data, text):
    """The text with one of its values another one."""
    places = [found.span() for found in VALUES.finditer(text)]
    begin, end = data.draw(st.sampled_from(places))
    return text[:begin] + data.draw(st.sampled_from(WRONG)) + text[end:]


def put_elsewhere(told):
    """The mission with its first waypoint moved, and one added behind it."""
    at = next((k for k, one in enumerate(told.orders) if one.kind is Kind.WAYPOINT and one.place), None)
    if at is None:
        return told
    latitude, longitude, altitude = told.orders[at].place
    there = (latitude / 2 + 1, longitude / 2, type(altitude)(altitude.metres + 1))
    added = Order(0, Kind.WAYPOINT, "added", place=there)
    return replace(
        told, orders=(*told.orders[:at], replace(told.orders[at], place=there), added, *told.orders[at + 1 :])
    )


@settings(max_examples=150)
@drawn(st.sampled_from([name for name in given.EVERY_FORMAT if not name.endswith(".kmz")] + ["d.kmz"]), st.data())
def test_files_with_a_wrong_value_are_read_and_changed_or_refused(tmp_path_factory, name, data):
    folder = tmp_path_factory.mktemp("wrong")
    if name == "d.kmz":
        line, plan = given.waylines(), given.template("EGM96", geoid=40.0)
        line, plan = (
            (wrong_somewhere(data, line), plan) if data.draw(st.booleans()) else (line, wrong_somewhere(data, plan))
        )
        content, how = given.kmz(wpmz__waylines_wpml=line, wpmz__template_kml=plan), {}
    else:
        text, how = given.EVERY_FORMAT[name]
        content = wrong_somewhere(data, text)
    path = given.write(folder / name, content)
    try:
        told = sky.read_waypoints(path, **how)
        sky.write_waypoints(put_elsewhere(told), folder / f"out-{name}")
    except sky.InputError as error:
        said = str(error)
    else:
        said = str(path)
    assert str(path) in said


@drawn(st.sampled_from(list(given.EVERY_FORMAT)), st.data())
def test_damaged_files_are_read_or_refused(tmp_path_factory, name, data):
    content, how = given.EVERY_FORMAT[name]
    content = content if isinstance(content, bytes) else content.encode()
    cut = data.draw(st.integers(0, len(content)))
    middle = data.draw(st.binary(max_size=4))
    path = given.write(tmp_path_factory.mktemp("damaged") / name, content[:cut] + middle + content[cut + len(middle) :])
    try:
        told = sky.read_waypoints(path, **how)
    except sky.InputError:
        return
    sky.write_waypoints(told, path)
