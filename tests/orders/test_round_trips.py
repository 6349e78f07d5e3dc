"""Missions that are written again: byte for byte if nothing has changed, and else but for what has."""

import copy
import io
import json
import time
import zipfile
from codecs import BOM_UTF8
from dataclasses import replace

import pytest
from hypothesis import given as drawn
from hypothesis import strategies as st

import skyverse as sky
import written_missions as given
from skyverse.model.waypoints import Order
from skyverse.model.waypoints import OrderKind as Kind

EVERY = list(given.EVERY_FORMAT)


def read(path):
    return sky.read_waypoints(path, **given.EVERY_FORMAT.get(path.name, ("", {}))[1])


def stored(tmp_path, name):
    return given.write(tmp_path / name, given.EVERY_FORMAT[name][0])


def flown(waypoints):
    return [k for k, order in enumerate(waypoints.orders) if order.kind is Kind.WAYPOINT and order.place]


def shifted(order, north=0.0005, up=2.25):
    latitude, longitude, altitude = order.place
    return replace(order, place=(latitude + north, longitude - north, type(altitude)(altitude.metres + up)))


def changed(waypoints, moved=1, after=0):
    """The waypoint after the first is moved, and one is added after another."""
    orders, places = list(waypoints.orders), flown(waypoints)
    orders[places[moved]] = shifted(orders[places[moved]])
    here = orders[places[after]]
    orders.insert(places[after] + 1, Order(0, Kind.WAYPOINT, "added", place=shifted(here, 0.0002, 5.5).place))
    return replace(waypoints, orders=tuple(orders))


def write(waypoints, path):
    sky.write_waypoints(waypoints, path)
    return read(path)


@pytest.mark.parametrize("name", EVERY)
def test_a_file_in_which_nothing_has_changed_is_the_same_to_the_byte(tmp_path, name):
    path = stored(tmp_path, name)
    (tmp_path / "out").mkdir()
    for waypoints in (read(path), copy.deepcopy(read(path))):
        sky.write_waypoints(waypoints, tmp_path / "out" / name)
        assert (tmp_path / "out" / name).read_bytes() == path.read_bytes()


@pytest.mark.parametrize("name", [name for name in EVERY if not name.endswith(".kmz")])
def test_a_mark_of_the_bytes_order_stays_where_a_file_has_it(tmp_path, name):
    path = stored(tmp_path, name)
    path.write_bytes(BOM_UTF8 + path.read_bytes())
    write(changed(read(path)), path)
    assert path.read_bytes().startswith(BOM_UTF8)
    assert path.read_bytes().count(BOM_UTF8) == 1


def close(one, other):
    (a, b, c), (d, e, f) = one, other
    same = type(c) is type(f) and c.metres == pytest.approx(f.metres, abs=1e-4)
    return same and (a, b) == pytest.approx((d, e), abs=1e-9, nan_ok=True)


@pytest.mark.parametrize("name", EVERY)
@pytest.mark.parametrize("where", ["first", "last"])
def test_moved_and_added_waypoints_are_read_back_and_all_other_orders_are_as_they_were(tmp_path, name, where):
    before = read(stored(tmp_path, name))
    meant = changed(before, *((0, 0) if where == "first" else (-1, -1)))
    (tmp_path / "out").mkdir()
    after = write(meant, tmp_path / "out" / name)
    added = next(k for k, order in enumerate(meant.orders) if order.item is None)
    # what DJI and Litchi do at a waypoint comes after it, so that a waypoint is added behind all of that
    gone = [order for k, order in enumerate(meant.orders) if k != added]
    fresh = next(k for k, order in enumerate(after.orders) if close_or_none(order, meant.orders[added]))
    rest = [order for k, order in enumerate(after.orders) if k != fresh]
    assert len(after.orders) == len(meant.orders)
    for one, other in zip(rest, gone, strict=True):
        assert one.place is other.place is None or close(one.place, other.place)
        assert same_but_for_numbers(one, other)


def close_or_none(one, other):
    return one.place is not None and one.kind is other.kind and close(one.place, other.place)


def same_but_for_numbers(one, other):
    plain = {"number": 0, "item": 0, "place": None, "to": None}
    return replace(one, **plain) == replace(other, **plain)


@pytest.mark.parametrize("name", EVERY)
def test_what_is_written_changed_twice_is_what_is_written_at_once(tmp_path, name):
    before = read(stored(tmp_path, name))
    (tmp_path / "out").mkdir()
    once = write(changed(before), tmp_path / "out" / name)
    again = write(changed(once, 2, 2), tmp_path / "out" / name)
    assert len(flown(again)) == len(flown(before)) + 2


def test_jumps_still_lead_to_their_waypoints(tmp_path):
    for name, target in (("m.plan", 4), ("m.waypoints", 3)):
        before = read(stored(tmp_path, name))
        orders = list(before.orders)
        orders.insert(1, Order(0, Kind.WAYPOINT, "added", place=shifted(orders[0]).place))
        if name == "m.waypoints":
            orders[1] = replace(orders[1], place=shifted(orders[2]).place)
        after = write(replace(before, orders=tuple(orders)), tmp_path / f"out-{name}")
        (jump,) = (order for order in after.orders if order.kind is Kind.JUMP)
        assert jump.to == target
        assert after.orders[jump.to - 1].place == before.orders[jump.to - 2].place


def test_a_waypoint_that_is_added_among_turns_is_stopped_at(tmp_path):
    for name in ("m.wpml.kmz", "m.csv"):
        before = read(stored(tmp_path, name))
        at = next(k for k, place in enumerate(flown(before)) if before.orders[place].radius)
        after = write(changed(before, 0, at), tmp_path / f"out-{name}")
        order = after.orders[flown(after)[at + 1]]
        assert not order.curved
        assert order.seconds > 0 or order.radius == 0


def test_a_drone_that_takes_off_higher_is_told_so_in_both_files(tmp_path):
    before = read(stored(tmp_path, "m.wpml.kmz"))
    first = before.orders[0]
    higher = replace(first, place=(*first.place[:2], type(first.place[2])(35.5)))
    after = write(replace(before, orders=(higher, *before.orders[1:])), tmp_path / "out.wpml.kmz")
    assert after.orders[0].place[2].metres == 35.5
    assert [order.place for order in after.orders[1:]] == [order.place for order in before.orders[1:]]
    with zipfile.ZipFile(tmp_path / "out.wpml.kmz") as archive:
        assert b"<wpml:takeOffSecurityHeight>35.5<" in archive.read("wpmz/template.kml")


def test_turns_stops_and_the_return_altitude_are_written_where_files_have_them(tmp_path):
    for name, wide in (("m.wpml.kmz", 5.0), ("m.csv", 4.5)):
        before = read(stored(tmp_path, name))
        at = next(k for k, order in enumerate(before.orders) if order.radius == wide)
        for change in ({"radius": 1.25}, {"seconds": 1.0}):
            orders = list(before.orders)
            orders[at] = replace(orders[at], **change)
            after = write(replace(before, orders=tuple(orders)), tmp_path / f"out-{name}")
            assert (after.orders[at].radius or 0.0) == change.get("radius", 0.0)
            assert after.orders[at].seconds > 0 or "seconds" not in change or name == "m.csv"
            rest = [order for k, order in enumerate(before.orders) if k != at]
            assert [repr(order) for k, order in enumerate(after.orders) if k != at] == list(map(repr, rest))
    before = read(stored(tmp_path, "m.wpml.kmz"))
    after = write(replace(before, return_altitude=62.5), tmp_path / "out.wpml.kmz")
    assert after.return_altitude == 62.5
    assert repr(after.orders) == repr(before.orders)


# ------------------------------------------------------------------------------------------ foreign readers
PLAN_FIELDS = ("command", "frame", "param1", "param2", "param3", "param4", "x", "y", "z", "autocontinue")


def test_mavsdk_finds_all_items_of_a_plan_that_were_not_changed_identical(stations, tmp_path):
    def items(path):
        found = stations.mission.import_qgroundcontrol_mission(str(path)).mission_items
        return [repr([getattr(item, field) for field in PLAN_FIELDS]) for item in found]

    path, out = stored(tmp_path, "m.plan"), tmp_path / "out.plan"
    write(changed(read(path)), out)
    before, after = items(path), items(out)
    assert len(after) == len(before) + 1
    jump = next(k for k, order in enumerate(read(path).orders) if order.kind is Kind.JUMP)
    kept = [k for k in range(len(before)) if k not in (flown(read(path))[1], jump)]
    assert [after[k + (k > flown(read(path))[0])] for k in kept] == [before[k] for k in kept]


def test_pymavlink_finds_all_rows_that_were_not_changed_identical(tmp_path):
    mavwp = pytest.importorskip("pymavlink.mavwp", reason="reads .waypoints")

    def rows(path):
        loader = mavwp.MAVWPLoader()
        loader.load(str(path))
        return [repr({**loader.wp(k).to_dict(), "seq": 0}) for k in range(loader.count())]

    path, out = stored(tmp_path, "m.waypoints"), tmp_path / "out.waypoints"
    before = read(path)
    write(changed(before), out)
    first, second = (before.orders[k].number for k in flown(before)[:2])
    old, new = rows(path), rows(out)
    assert len(new) == len(old) + 1
    kept = [k for k in range(len(old)) if k != second]
    assert [new[k + (k > first)] for k in kept] == [old[k] for k in kept]


def trees(path):
    """What lxml finds in the files of an archive: the leaves of each waypoint, and all else."""
    etree = pytest.importorskip("lxml.etree", reason="lxml is not installed")
    with zipfile.ZipFile(path) as archive:
        for name in archive.namelist():
            if not name.endswith((".kml", ".wpml")):
                continue
            root = etree.fromstring(archive.read(name))
            marks = root.findall(".//{*}Placemark")
            told = [
                [(one.tag, (one.text or "").strip()) for one in mark.iter() if isinstance(one.tag, str)]
                for mark in marks
            ]
            for mark in marks:
                mark.getparent().remove(mark)
            yield name, told, [(one.tag, (one.text or "").strip()) for one in root.iter()]


def without(leaves, *tags):
    return [(tag, text) for tag, text in leaves if tag.rpartition("}")[2] not in tags]


def test_lxml_finds_waylines_and_template_identical_but_for_places_and_indices(tmp_path):
    path, out = stored(tmp_path, "m.wpml.kmz"), tmp_path / "out.wpml.kmz"
    write(changed(read(path)), out)
    moving = ("coordinates", "executeHeight", "height", "ellipsoidHeight")
    counted = ("index", "actionGroupStartIndex", "actionGroupEndIndex")
    for (name, old, rest), (other, new, still) in zip(trees(path), trees(out), strict=True):
        assert (name, rest) == (other, still)
        first, added, *after = new
        assert first == old[0]
        assert without(after[0], *moving, *counted) == without(old[1], *moving, *counted)
        assert without(after[0], *counted) != without(old[1], *counted)
        for one, kept in zip(after[1:], old[2:], strict=True):
            assert without(one, *counted) == without(kept, *counted)
        turning = ("waypointTurnMode", "waypointTurnDampingDist", "useStraightLine")
        assert without(added, *moving, *counted, *turning) == without(old[0], *moving, *counted, *turning)
        for k, mark in enumerate(new):
            numbers = {int(text) for tag, text in mark if tag.rpartition("}")[2] in ("index", "actionGroupStartIndex")}
            assert numbers == {k}
    with zipfile.ZipFile(out) as archive, zipfile.ZipFile(path) as before:
        assert archive.namelist() == before.namelist()
        assert archive.read("wpmz/res/note.txt") == b"\x00kept"
        assert b"<!-- kept -->" in archive.read("wpmz/waylines.wpml")


def test_djikmz_reads_the_same_waypoints_in_a_template(tmp_path):
    pytest.importorskip("djikmz", reason="djikmz is not installed")
    xmltodict = pytest.importorskip("xmltodict", reason="xmltodict is not installed")
    from djikmz.model.waypoint import Waypoint

    def places(path):
        with zipfile.ZipFile(path) as archive:
            data = xmltodict.parse(archive.read("wpmz/template.kml"))["kml"]["Document"]["Folder"]["Placemark"]
        for mark in data:
            mark.pop("wpml:actionGroup", None)
        return [Waypoint.from_dict(mark) for mark in data]

    path, out = stored(tmp_path, "m.wpml.kmz"), tmp_path / "out.wpml.kmz"
    after = write(changed(read(path)), out)
    found, orders = places(out), [after.orders[k] for k in flown(after)]
    assert [one.waypoint_id for one in found] == list(range(5))
    theirs = [(one.latitude, one.longitude, one.height) for one in found]
    ours = [(*order.place[:2], order.place[2].metres) for order in orders]
    for one, other in zip(theirs, ours, strict=True):
        assert one == pytest.approx(other, abs=1e-9)
    old = places(path)
    assert [vars(found[k]) | {"waypoint_id": 0} for k in (0, 3, 4)] == [
        vars(old[k]) | {"waypoint_id": 0} for k in (0, 2, 3)
    ]


@pytest.mark.filterwarnings("ignore:.*invalid escape sequence")
def test_litchi_wp_finds_all_lines_that_were_not_changed_identical(tmp_path):
    pytest.importorskip("litchi_wp", reason="litchi_wp is not installed")
    from litchi_wp.waypoint import Waypoint

    path, out = stored(tmp_path, "m.csv"), tmp_path / "out.csv"
    after = write(changed(read(path)), out)
    old, new = (Waypoint.from_file(str(file)) for file in (path, out))
    assert len(new) == len(old) + 1
    lines = [one.to_line() for one in new]
    assert [lines[0], lines[3]] == [old[0].to_line(), old[2].to_line()]
    places = [after.orders[k].place for k in flown(after)]
    found = [tuple(map(float, line.split(",")[:3])) for line in lines]
    assert found == [pytest.approx((place[0], place[1], place[2].metres)) for place in places]
    assert lines[2].split(",")[3:] == old[1].to_line().split(",")[3:]


def test_fastkml_and_gpxpy_read_the_places_that_were_written(tmp_path):
    fastkml = pytest.importorskip("fastkml", reason="reads KML")
    gpxpy = pytest.importorskip("gpxpy", reason="reads GPX")
    (tmp_path / "out").mkdir()
    for name in ("line.kml", "points.kml", "m.gpx"):
        out = tmp_path / "out" / name
        after = write(changed(read(stored(tmp_path, name))), out)
        if name == "m.gpx":
            (route,) = gpxpy.parse(out.read_text()).routes
            found = [(one.latitude, one.longitude, one.elevation) for one in route.points]
        else:
            marks = fastkml.KML.parse(out, strict=False).features[0].features
            found = [(y, x, z) for mark in marks for x, y, z in mark.geometry.coords]
        assert found == [(*order.place[:2], order.place[2].metres) for order in after.orders]


# ------------------------------------------------------------------------------------------ random items
COMMANDS = st.sampled_from([16, 17, 18, 19, 21, 22, 31, 82, 93, 112, 115, 178, 189, 195, 201, 206, 530, 31010])
NUMBERS = st.one_of(st.just(0.0), st.floats(0, 99, width=16), st.integers(0, 9).map(float))
ITEMS = st.lists(
    st.tuples(
        COMMANDS,
        st.sampled_from([0, 3, 10]),
        st.tuples(*[NUMBERS] * 4, st.floats(1, 89), st.floats(-179, 179), st.floats(-50, 500)),
    ),
    min_size=2,
    max_size=12,
)


def as_plan(rows):
    return given.plan(
        [given.item(command, *numbers, frame=frame, number=k) for k, (command, frame, numbers) in enumerate(rows, 1)]
    )


def as_wpl(rows, home=True):
    lines = [
        f"{k}\t0\t{frame}\t{command}\t" + "\t".join(map(repr, numbers)) + "\t1"
        for k, (command, frame, numbers) in enumerate(rows, int(home))
    ]
    return "\n".join([*(given.WPL.splitlines()[:2] if home else ["QGC WPL 120"]), *lines]) + "\n"


@drawn(ITEMS, st.data())
def test_any_items_survive_a_change_and_an_addition_number_for_number(tmp_path_factory, rows, data):
    folder = tmp_path_factory.mktemp("drawn")
    for name, text in (
        ("d.plan", as_plan(rows)),
        ("d.waypoints", as_wpl(rows)),
        ("d.txt", as_wpl(rows, home=False)),
    ):
        before = sky.read_waypoints(given.write(folder / name, text))
        places = [k for k, order in enumerate(before.orders) if order.place]
        if not places:
            continue
        at = data.draw(st.sampled_from(places))
        orders = list(before.orders)
        orders[at] = shifted(orders[at])
        added = Order(0, Kind.WAYPOINT, "added", place=orders[at].place)
        orders.insert(at, added)
        sky.write_waypoints(replace(before, orders=tuple(orders)), folder / f"out-{name}")
        found = items_of((folder / f"out-{name}").read_text())
        assert [one for k, one in enumerate(found) if k not in (at, at + 1)] == [
            one for k, one in enumerate(items_of(text)) if k != at
        ]
        assert found[at + 1][:6] == items_of(text)[at][:6]
        for one in found[at : at + 2]:
            assert one[6:] == pytest.approx((*orders[at + 1].place[:2], orders[at + 1].place[2].metres), abs=1e-9)


def items_of(text):
    """Command, frame and the seven numbers of each item, by the plainest reader that there can be."""
    if text.startswith("{"):
        items = json.loads(text)["mission"]["items"]
        return [(one["command"], one["frame"], *one["params"]) for one in items]
    rows = [line.split("\t") for line in io.StringIO(text).read().splitlines()]
    rows = rows[1 if rows[0] == ["QGC WPL 120"] else 2 :]
    return [(int(row[3]), int(row[2]), *map(float, row[4:11])) for row in rows]


@pytest.mark.parametrize("name", ["many.plan", "many.waypoints", "many.kml"])
def test_ten_thousand_items_are_read_and_changed_within_seconds(tmp_path, name):
    places = [(47 + k * 1e-6, 8.0, 30.0) for k in range(10_000)]
    line = " ".join(f"{longitude},{latitude},{metres}" for latitude, longitude, metres in places)
    rows = [(16, 3, (0.0, 0.0, 0.0, 0.0, *place)) for place in places]
    text = {
        "many.plan": as_plan(rows),
        "many.waypoints": as_wpl(rows),
        "many.kml": given.kml(given.kml_mark("Route", "LineString", line, "absolute")),
    }[name]
    path = given.write(tmp_path / name, text)
    read(stored(tmp_path, "m.plan"))  # so that everything is imported
    begin = time.process_time()
    waypoints = sky.read_waypoints(path)
    assert len(waypoints.orders) == 10_000
    assert time.process_time() - begin < 1
    sky.write_waypoints(changed(waypoints, 5000, 5000), path)
    assert time.process_time() - begin < 4
