"""Buildings of OpenStreetMap extracts, counted and shaped as others see them."""

import os
import struct
import zlib
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import skyverse as sky
from skyverse.model.altitude import FOOT

shapely = pytest.importorskip("shapely")
pytest.importorskip("pyproj")
pyogrio = pytest.importorskip("pyogrio")

from skyverse.maps.readers.dimensions import length_in_metres, number_of_levels  # noqa: E402
from zones import read_file  # noqa: E402

DATA = Path(os.environ.get("SKYVERSE_DATA", Path(__file__).parents[4] / "shared" / "data"))
NODES = {1: (7.0, 47.0), 2: (7.001, 47.0), 3: (7.001, 47.001), 4: (7.0, 47.001)}
NODES |= {5: (7.0004, 47.0004), 6: (7.0006, 47.0004), 7: (7.0006, 47.0006), 8: (7.0004, 47.0006)}
OUTER, INNER = [1, 2, 3, 4, 1], [5, 6, 7, 8, 5]
COURT = shapely.Polygon([NODES[n] for n in OUTER], [[NODES[n] for n in INNER]])


def tags_of(tags):
    return "".join(f'<tag k="{k}" v="{v}"/>' for k, v in tags.items())


def way(number, nodes, **tags):
    refs = "".join(f'<nd ref="{n}"/>' for n in nodes)
    return f'<way id="{number}">{refs}{tags_of(tags)}</way>'


def relation(number, members, **tags):
    refs = "".join(f'<member type="way" ref="{n}" role="{role}"/>' for n, role in members)
    return f'<relation id="{number}">{refs}{tags_of({"type": "multipolygon", **tags})}</relation>'


def osm(*things, nodes=NODES):
    places = "".join(f'<node id="{n}" lon="{x}" lat="{y}"/>' for n, (x, y) in nodes.items())
    return f'<?xml version="1.0" encoding="UTF-8"?><osm version="0.6">{places}{"".join(things)}</osm>'


@pytest.fixture
def read(tmp_path):
    def written(text, **choices):
        path = tmp_path / "city.osm"
        path.write_text(text, encoding="utf-8")
        return read_file(path, **choices)

    return written


def polygon(one):
    return shapely.Polygon(one.outline, one.holes)


def test_a_way_and_a_part_are_buildings_and_a_street_is_none(read):
    part = {"building:part": "yes", "height": "10 m", "min_height": "4"}
    found = read(
        osm(
            way(1, OUTER, building="house", name="Town &amp; hall", **{"building:levels": "2"}),
            way(2, INNER, **part),
            way(3, [1, 2], highway="service"),
            way(4, OUTER, building="no", height="3"),
        )
    )
    assert [(one.low, one.high) for one in found] == [
        (None, sky.AboveGround(9.0)),
        (sky.AboveGround(4.0), sky.AboveGround(10.0)),
    ]
    assert found[0].name == "Town & hall"
    assert found[0].where.endswith("city.osm: way 1")
    assert {one.kind for one in found} == {"building"}
    assert found[0].outline.tolist() == [list(NODES[n]) for n in OUTER[:-1]]


@pytest.mark.parametrize(
    "members",
    [
        [(1, "outer"), (2, "inner")],
        [(1, ""), (2, "inner")],
        [(3, "outer"), (4, "outer"), (2, "inner")],
        [(4, "outer"), (5, "inner"), (3, "outer"), (6, "inner")],
    ],
)
def test_a_relation_is_its_outer_ways_joined_without_its_inner_ones(read, members):
    ways = [way(1, OUTER), way(2, INNER), way(3, [1, 2, 3]), way(4, [1, 4, 3]), way(5, [5, 6, 7]), way(6, [5, 8, 7])]
    (found,) = read(osm(*ways, relation(9, members, building="yes", height="20")))
    assert polygon(found).equals(COURT)
    assert found.where.endswith("relation 9")


def test_a_relation_across_the_antimeridian_keeps_its_court(read):
    nodes = {number: ((x - 7.0005 + 360) % 360 - 180, y) for number, (x, y) in NODES.items()}
    block = relation(9, [(3, "outer"), (4, "outer"), (2, "inner")], building="yes", height="20")
    (found,) = read(osm(way(2, INNER), way(3, [1, 2, 3]), way(4, [1, 4, 3]), block, nodes=nodes))
    court = shapely.transform(COURT, lambda places: places + np.array([172.9995, 0]))
    turns = 360 * round((180 - found.outline[:, 0].mean()) / 360)
    moved = shapely.transform(polygon(found), lambda places: places + np.array([turns, 0]))
    assert moved.symmetric_difference(court).area < 1e-12


def test_what_an_extract_has_cut_off_is_left_out_and_told(read):
    whole = way(1, OUTER, building="yes", height="5")
    told = []
    found = read(
        osm(
            whole,
            way(2, [1, 2, 99, 1], building="yes"),
            way(3, [1, 2], building="yes"),
            relation(4, [(77, "outer")], building="yes"),
            relation(5, [(6, "outer")], building="yes"),
            way(6, [1, 2, 3]),
            relation(7, [(1, "outer"), (88, "inner")], building="yes", height="6"),
        ),
        tell=told.append,
    )
    assert [one.where.rsplit(": ", 1)[1] for one in found] == ["way 1", "relation 7"]
    assert not found[1].holes
    assert len(told) == 4
    assert all("left out" in sentence for sentence in told)


def test_an_open_outline_is_closed_and_told(read):
    told = []
    (found,) = read(osm(way(1, OUTER[:-1], building="yes", height="5")), tell=told.append)
    assert len(found.outline) == 4
    assert "open" in told[0]


@pytest.mark.parametrize(
    ("tags", "low", "high"),
    [
        ({"height": "10"}, 0, 10),
        ({"height": "10.5 m"}, 0, 10.5),
        ({"height": "33'"}, 0, 33 * FOOT),
        ({"height": "33 ft"}, 0, 33 * FOOT),
        ({"height": "7'4\""}, 0, (7 + 4 / 12) * FOOT),
        ({"building:levels": "3"}, 0, 12),
        ({"building:levels": "3", "roof:levels": "2"}, 0, 15),
        ({"building:levels": "3", "roof:height": "1.5"}, 0, 10.5),
        ({"building:levels": "3", "roof:shape": "flat"}, 0, 9),
        ({"building:levels": "2;4", "roof:shape": "flat"}, 0, 12),
        ({"height": "about ten", "building:levels": "1"}, 0, 6),
        ({"height": "20", "building:min_level": "2"}, 6, 20),
        ({"height": "20", "min_height": "25"}, 0, 20),
        ({"height": "-3"}, 0, 7),
        ({"height": "low"}, 0, 7),
        ({}, 0, 7),
    ],
)
def test_heights_follow_the_tags(read, tags, low, high):
    (found,) = read(
        osm(way(1, OUTER, building="yes", **{k: v.replace('"', "&quot;") for k, v in tags.items()})),
        building_height=7.0,
    )
    assert (found.low.metres if found.low else 0) == pytest.approx(low)
    assert found.high.metres == pytest.approx(high)


@given(st.floats(0.01, 900).map(lambda v: round(v, 2)), st.sampled_from(["", " m", "m", " metres"]))
def test_metres_are_read_back_as_they_were_written(value, unit):
    assert length_in_metres(f"{value}{unit}") == value
    assert length_in_metres(f"{value} ft") == pytest.approx(value * FOOT)


@given(st.text())
def test_any_text_is_a_height_or_none(text):
    for number in (length_in_metres(text), number_of_levels(text)):
        assert number is None or 0 <= number < 1e5


@pytest.mark.parametrize(
    "text",
    [
        osm(way(1, OUTER, building="yes")),
        osm(way(1, OUTER, building="yes", height="tall")),
        osm(),
        "<osm>",
        "",
        "<kml></kml>",
        '<!DOCTYPE osm [<!ENTITY a "aaaa">]><osm/>',
        osm(nodes={1: (200, 0)}),
        osm(nodes={1: ("nan", 0)}),
        '<osm><node id="x" lon="1" lat="2"/></osm>',
        '<osm><node id="1" lat="2"/></osm>',
        osm(way(1, OUTER, building="yes", height="3"), nodes={n: (0, 95 if n == 2 else n) for n in NODES}),
    ],
)
def test_what_cannot_be_used_is_refused_in_one_sentence(read, text, refuses):
    with refuses():
        read(text)


@given(st.data())
def test_broken_bytes_are_read_or_refused_in_one_sentence(tmp_path_factory, data):
    content = bytearray(
        osm(way(1, OUTER, building="yes", height="3"), relation(2, [(1, "outer")], building="a")).encode()
    )
    for _ in range(data.draw(st.integers(1, 4))):
        content[data.draw(st.integers(0, len(content) - 1))] = data.draw(st.integers(0, 255))
    path = tmp_path_factory.mktemp("broken") / "city.osm"
    path.write_bytes(content[: data.draw(st.integers(0, len(content)))])
    try:
        message = "" if read_file(path, building_height=3.0) else "nothing"
    except sky.InputError as error:
        message = str(error)
    assert not message or str(path) in message


@pytest.mark.skipif(not (DATA / "suburb.osm").exists(), reason="needs ../shared/data/suburb.osm")
@pytest.mark.filterwarnings("ignore:Non closed ring:RuntimeWarning")
def test_a_suburb_has_as_many_buildings_as_gdal_counts():
    rows = pyogrio.raw.read(DATA / "suburb.osm", layer="multipolygons", columns=["osm_way_id", "building"])
    theirs = {
        int(number): shapely.from_wkb(shape)
        for number, building, shape in zip(*rows[3], rows[2], strict=True)
        if building is not None and number is not None
    }
    told = []
    ours = read_file(DATA / "suburb.osm", building_height=6.0, tell=told.append)
    by_way = {}
    for one in ours:
        by_way.setdefault(int(one.where.rsplit(" ", 1)[1]), []).append(polygon(one))
    assert by_way.keys() == theirs.keys()
    assert len(theirs) > 30
    for number, shapes in by_way.items():
        whole = shapely.union_all(shapes)
        assert whole.buffer(1e-12).covers(shapely.make_valid(theirs[number]).buffer(0))


def varint(value):
    out = bytearray()
    while True:
        value, seven = value >> 7, value & 127
        out.append(seven | (128 if value else 0))
        if not value:
            return bytes(out)


def entry(number, payload):
    if isinstance(payload, int):
        return varint(number << 3) + varint(payload)
    return varint(number << 3 | 2) + varint(len(payload)) + payload


def zigzag(values):
    steps = np.diff([0, *values]).tolist()
    return b"".join(varint(2 * s if s >= 0 else -2 * s - 1) for s in steps)


def pbf(things):
    """Return an extract of ways with tags in OpenStreetMap's binary format."""
    words = ["", *sorted({word for _, _, tags in things for pair in tags.items() for word in pair})]

    def block(kind, content):
        packed = entry(2, len(content)) + entry(3, zlib.compress(content))
        header = entry(1, kind) + entry(3, len(packed))
        return struct.pack(">I", len(header)) + header + packed

    head = entry(4, b"OsmSchema-V0.6") + entry(4, b"DenseNodes")
    numbers = sorted(NODES)
    dense = entry(1, zigzag(numbers))
    dense += entry(8, zigzag([round(NODES[n][1] * 1e7) for n in numbers]))
    dense += entry(9, zigzag([round(NODES[n][0] * 1e7) for n in numbers]))
    ways = b""
    for number, nodes, tags in things:
        keys = b"".join(varint(words.index(k)) for k in tags)
        values = b"".join(varint(words.index(v)) for v in tags.values())
        ways += entry(3, entry(1, number) + entry(2, keys) + entry(3, values) + entry(8, zigzag(nodes)))
    table = entry(1, b"".join(entry(1, word.encode()) for word in words))
    return block(b"OSMHeader", head) + block(b"OSMData", table + entry(2, entry(2, dense)) + entry(2, ways))


def test_the_binary_format_gives_the_same_as_xml(tmp_path, read):
    things = [
        (1, OUTER, {"building": "yes", "height": "12", "name": "A"}),
        (2, INNER, {"building:part": "yes", "height": "20", "min_height": "12"}),
        (3, [1, 2], {"highway": "service"}),
    ]
    path = tmp_path / "city.osm.pbf"
    path.write_bytes(pbf(things))
    theirs = read(osm(*(way(number, nodes, **tags) for number, nodes, tags in things)))
    ours = read_file(path)
    assert len(ours) == 2
    for one, other in zip(ours, theirs, strict=True):
        assert (one.low, one.high, one.name) == (other.low, other.high, other.name)
        assert np.allclose(one.outline, other.outline, atol=1e-9)
        assert one.where.rsplit(": ", 1)[1] == other.where.rsplit(": ", 1)[1]


def test_what_a_file_is_decides_not_its_name(tmp_path, read, refuses):
    things = [(1, OUTER, {"building": "yes", "height": "12"})]
    (tmp_path / "binary.osm").write_bytes(pbf(things))
    text = osm(*(way(number, nodes, **tags) for number, nodes, tags in things))
    (tmp_path / "xml.osm.pbf").write_text(text)
    (one,), (other,) = (read_file(tmp_path / name) for name in ("binary.osm", "xml.osm.pbf"))
    assert np.allclose(one.outline, other.outline, atol=1e-9)
    assert one.high == other.high
    (tmp_path / "other.osm.pbf").write_bytes(b"PK\x03\x04 something")
    with refuses():
        read_file(tmp_path / "other.osm.pbf")


def test_a_binary_way_that_does_not_close_is_told_once(tmp_path):
    told = []
    broken = [(n, [1, 2, 3, 4], {"building": "yes", "height": "12", "area": "yes"}) for n in (1, 2)]
    (tmp_path / "city.osm.pbf").write_bytes(pbf([*broken, (3, OUTER, {"building": "yes", "height": "12"})]))
    found = read_file(tmp_path / "city.osm.pbf", tell=told.append)
    assert len(found) >= 1
    assert not any("OGR" in sentence for sentence in told)


def test_a_binary_file_cut_off_is_refused(tmp_path):
    whole = pbf([(1, OUTER, {"building": "yes", "height": "12"})])
    path = tmp_path / "city.osm.pbf"
    for cut in range(0, len(whole) - 1, 45):
        path.write_bytes(whole[:cut])
        with pytest.raises(sky.InputError, match=r"city\.osm\.pbf"):
            read_file(path)
