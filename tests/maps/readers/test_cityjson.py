"""Buildings of CityJSON: never smaller than their surfaces, as high as their corners, where their CRS says."""

import copy
import json
import os
from pathlib import Path

import numpy as np
import pytest

import skyverse as sky

pyproj = pytest.importorskip("pyproj")
shapely = pytest.importorskip("shapely")

from zones import read_file  # noqa: E402

DATA = Path(os.environ.get("SKYVERSE_DATA", Path(__file__).parents[4] / "shared" / "data"))
needs_data = pytest.mark.skipif(not (DATA / "delft.city.json").exists(), reason="needs ../shared/data/*.city.json")
BACK = pyproj.Transformer.from_crs("OGC:CRS84", "EPSG:28992", always_xy=True)

X, Y = 85000, 446000
CUBE = [[X + x, Y + y, z] for z in (1, 7.5) for x, y in ((0, 0), (10, 0), (10, 8), (0, 8))]
FACES = [[[0, 3, 2, 1]], [[4, 5, 6, 7]], *([[k, (k + 1) % 4, (k + 1) % 4 + 4, k + 4]] for k in range(4))]


def city(objects=None, vertices=CUBE, **more):
    house = {"type": "Building", "geometry": [solid(FACES)]}
    return {
        "type": "CityJSON",
        "version": "2.0",
        "metadata": {"referenceSystem": "https://www.opengis.net/def/crs/EPSG/0/7415"},
        "transform": {"scale": [1, 1, 1], "translate": [0, 0, 0]},
        "CityObjects": objects or {"house": house},
        "vertices": vertices,
        **more,
    }


def solid(faces, lod="1.2"):
    return {"type": "Solid", "lod": lod, "boundaries": [faces]}


def surfaces(faces, lod="1.2"):
    return {"type": "MultiSurface", "lod": lod, "boundaries": faces}


@pytest.fixture
def read(tmp_path):
    def written(document, **choices):
        path = tmp_path / "city.json"
        path.write_text(json.dumps(document))
        return read_file(path, **choices)

    return written


def flat(one):
    """Return a feature's footprint in its file's metres."""
    rings = [np.column_stack(BACK.transform(*ring.T)) for ring in (one.outline, *one.holes)]
    return shapely.Polygon(rings[0], rings[1:])


def near(one, other, metres=0.01):
    return one.buffer(metres).covers(other) and other.buffer(metres).covers(one)


def test_a_solid_is_its_shadow_from_its_lowest_to_its_highest_corner(read):
    (house,) = read(city())
    assert near(flat(house), shapely.box(X, Y, X + 10, Y + 8))
    assert (house.low, house.high) == (sky.AboveSea(1.0), sky.AboveSea(7.5))
    assert (house.kind, house.name) == ("building", "house")
    assert house.where.endswith("city.json: house")


def test_vertices_are_scaled_and_moved(read):
    vertices = [[round((x - X) * 1000), round((y - Y) * 1000), round(z * 1000)] for x, y, z in CUBE]
    transform = {"scale": [0.001, 0.001, 0.001], "translate": [X, Y, 0]}
    (house,) = read(city(vertices=vertices, transform=transform))
    assert near(flat(house), shapely.box(X, Y, X + 10, Y + 8))
    assert house.high == sky.AboveSea(7.5)


def test_a_roof_that_reaches_over_the_walls_counts_and_a_courtyard_stays_open(read):
    extra = [[X + x, Y + y, 7.5] for x, y in ((-2, -1), (12, -1), (12, 9), (-2, 9))]
    court = [[X + x, Y + y, 7.5] for x, y in ((4, 3), (6, 3), (6, 5), (4, 5))]
    ring = [[8, 9, 10, 11], [12, 13, 14, 15]]
    (house,) = read(city({"a": {"type": "Building", "geometry": [surfaces([ring, *FACES[2:]])]}}, CUBE + extra + court))
    assert near(flat(house), shapely.box(X - 2, Y - 1, X + 12, Y + 9) - shapely.box(X + 4, Y + 3, X + 6, Y + 5))


TREE = [[x, y, z] for z in (0, 4) for x, y in ((-1, -2), (1, -2), (1, 2), (-1, 2))]


def instances(*geometries, **more):
    held = {"templates": [solid(FACES, "1.0"), surfaces(FACES, 2)], "vertices-templates": TREE}
    objects = {f"t{k}": {"type": "SolitaryVegetationObject", "geometry": [one]} for k, one in enumerate(geometries)}
    return city(objects, **{"geometry-templates": held, **more})


def instance(matrix, template=0, at=0):
    rows = np.vstack([np.asarray(matrix, dtype=float), [0, 0, 0, 1]])
    return {
        "type": "GeometryInstance",
        "template": template,
        "boundaries": [at],
        "transformationMatrix": rows.ravel().tolist(),
    }


def test_templates_are_scaled_turned_and_moved_to_their_vertex(read):
    whole = np.eye(3, 4)
    turned = np.array([[0, -3, 0, 5], [3, 0, 0, 6], [0, 0, 2, 1]])  # three times as wide, a quarter turn, moved
    one, other = read(instances(instance(whole, at=4), instance(turned, template=1, at=2)))
    assert near(flat(one), shapely.box(X - 1, Y - 2, X + 1, Y + 2))
    assert (one.low, one.high, one.kind) == (sky.AboveSea(7.5), sky.AboveSea(11.5), "tree")
    assert near(flat(other), shapely.box(X + 10 + 5 - 6, Y + 8 + 6 - 3, X + 10 + 5 + 6, Y + 8 + 6 + 3))
    assert (other.low, other.high) == (sky.AboveSea(2.0), sky.AboveSea(10.0))


def test_a_template_has_its_own_level_of_detail(read):
    low = np.array([[1, 0, 0, 0], [0, 1, 0, 0], [0, 0, 1, 9]])
    both = [instance(np.eye(3, 4), template=1), instance(low, template=0)]
    document = city(
        {"t": {"type": "CityFurniture", "geometry": both}},
        **{"geometry-templates": {"templates": [solid(FACES, "1.0"), solid(FACES, "2")], "vertices-templates": TREE}},
    )
    assert read(document)[0].low == sky.AboveSea(1.0)
    assert read(document, lod="1")[0].low == sky.AboveSea(10.0)


@pytest.mark.parametrize(
    "change",
    [
        {"template": 2},
        {"template": True},
        {"boundaries": [8]},
        {"boundaries": []},
        {"transformationMatrix": [1] * 15},
        {"transformationMatrix": [1] * 16},
        {"transformationMatrix": [None] * 12 + [0, 0, 0, 1]},
    ],
)
def test_a_broken_instance_is_refused(read, change, refuses):
    with refuses():
        read(instances({**instance(np.eye(3, 4)), **change}))
    with refuses():
        read(instances(instance(np.eye(3, 4)), **{"geometry-templates": {"templates": [], "vertices-templates": 3}}))


def test_points_and_lines_get_the_width_that_is_asked_for(read):
    points = {"type": "MultiPoint", "lod": "0", "boundaries": [0, 6]}
    line = {"type": "MultiLineString", "lod": "0", "boundaries": [[1, 6], [6, 7]]}
    document = city(
        {
            "house": {"type": "Building", "geometry": [solid(FACES)]},
            "masts": {"type": "CityFurniture", "geometry": [points]},
            "wire": {"type": "OtherConstruction", "geometry": [line]},
        }
    )
    told = []
    assert len(read(document, tell=told.append)) == 1
    assert sum("points or lines; give Reading.buffer to give them a width" in sentence for sentence in told) == 2
    _, *masts, wire, last = read(document, buffer=2.0)
    assert [one.name for one in masts] == ["masts", "masts"]
    for one, at in zip(masts, ((0, 0), (10, 8)), strict=True):
        assert near(flat(one), shapely.Point(X + at[0], Y + at[1]).buffer(2.0, 64), 0.02)
        assert (one.low, one.high) == (sky.AboveSea(-1.0), sky.AboveSea(9.5))
    both = shapely.union_all([flat(wire), flat(last)])
    assert near(both, shapely.LineString([(X + 10, Y), (X + 10, Y + 8), (X, Y + 8)]).buffer(2.0, 64), 0.03)


def test_walls_that_stand_alone_are_thin_but_not_lost(read):
    (wall,) = read(city({"a": {"type": "Building", "geometry": [surfaces(FACES[2:3])]}}))
    assert flat(wall).buffer(0.001).covers(shapely.LineString([(X, Y), (X + 10, Y)]))
    assert flat(wall).area < 0.5


def test_the_highest_level_of_detail_is_taken_unless_another_is_asked_for(read, refuses):
    hut = [[X + x, Y + y, z] for z in (1, 3) for x, y in ((0, 0), (1, 0), (1, 1), (0, 1))]
    small = [[[n + 8 for n in ring] for ring in face] for face in FACES]
    document = city({"a": {"type": "Building", "geometry": [solid(small, "2.2"), solid(FACES, 1)]}}, CUBE + hut)
    assert read(document)[0].high == sky.AboveSea(3.0)
    assert read(document, lod="1")[0].high == sky.AboveSea(7.5)
    with refuses():
        read(document, lod="3")


def test_parts_are_features_of_their_own_and_roads_are_left_out_and_told(read):
    objects = {
        "house": {"type": "Building", "children": ["part"]},
        "part": {"type": "BuildingPart", "parents": ["house"], "geometry": [solid(FACES)]},
        "many": {"type": "Building", "geometry": [{"type": "MultiSolid", "lod": "1", "boundaries": [[FACES]]}]},
        "street": {"type": "Road", "geometry": [surfaces(FACES)]},
    }
    told = []
    assert [one.name for one in read(city(objects), tell=told.append)] == ["part", "many"]
    assert len(told) == 1
    assert told[0].endswith("city.json: 1 left out, which are no obstacles or of unknown type: 1 Road")


def test_what_else_stands_in_the_way_is_read_with_its_kind(read):
    kinds = {"Bridge": "bridge", "SolitaryVegetationObject": "tree", "CityFurniture": "furniture"}
    objects = {name: {"type": name, "geometry": [solid(FACES)]} for name in kinds}
    flat = {"type": "PlantCover", "geometry": [surfaces(FACES[:1])]}
    point = {"type": "SolitaryVegetationObject", "geometry": [{"type": "MultiPoint", "lod": "1", "boundaries": [0]}]}
    told = []
    found = read(city({**objects, "lawn": flat, "point": point}), kind="building", tell=told.append)
    assert {one.name: one.kind for one in found} == kinds
    assert all(one.low == sky.AboveSea(1.0) and one.solid for one in found)
    assert [sentence.split(": ")[1][:6] for sentence in told] == ["1 of t", "1 of k"]


def test_a_level_of_detail_is_a_number(read, refuses):
    with refuses():
        read(city(), lod="high")


def test_a_flat_footprint_gets_its_height_from_its_attributes_or_the_user(read, refuses):
    flat_one = {"type": "Building", "geometry": [surfaces(FACES[:1], "0")]}
    assert read(city({"a": {**flat_one, "attributes": {"measuredHeight": 9.5}}}), unit="m")[0].high == sky.AboveGround(
        9.5
    )
    assert read(city({"a": flat_one}), building_height=4.0)[0].high == sky.AboveGround(4.0)
    with refuses():
        read(city({"a": flat_one}))


@pytest.mark.parametrize(
    "said",
    [{"referenceSystem": "urn:ogc:def:crs:EPSG::7415"}, {"crs": {"epsg": 7415}}, {"referenceSystem": "EPSG:7415"}],
)
def test_older_names_of_the_coordinate_system_are_known(read, said):
    assert near(flat(read(city(metadata=said, version="1.0"))[0]), shapely.box(X, Y, X + 10, Y + 8))


def test_in_a_system_in_feet_altitudes_need_a_unit(read, refuses):
    corner = pyproj.Transformer.from_crs("OGC:CRS84", "EPSG:2263", always_xy=True).transform(-74.0, 40.7)
    vertices = [[corner[0] + x - X, corner[1] + y - Y, z] for x, y, z in CUBE]
    town = city(vertices=vertices, metadata={"referenceSystem": "EPSG:2263"})
    with refuses():
        read(town, altitudes="amsl")
    (house,) = read(town, altitudes="amsl", unit="ft")
    assert house.high.metres == pytest.approx(7.5 * 0.3048)


def test_altitudes_in_feet_become_metres(read):
    corner = pyproj.Transformer.from_crs("OGC:CRS84", "EPSG:2263", always_xy=True).transform(-74.0, 40.7)
    vertices = [[corner[0] + x - X, corner[1] + y - Y, z] for x, y, z in CUBE]
    (house,) = read(city(vertices=vertices, metadata={"referenceSystem": "EPSG:2263+6360"}))
    assert house.high.metres == pytest.approx(7.5 * 1200 / 3937)


@pytest.mark.parametrize(
    "change",
    [
        {"metadata": {}},
        {"metadata": {"referenceSystem": "EPSG:28992"}},
        {"metadata": {"referenceSystem": "EPSG:4979"}},
        {"metadata": {"referenceSystem": "EPSG:no"}},
        {"version": "0.9"},
        {"vertices": [[0, 1]]},
        {"vertices": CUBE[:5]},
        {"vertices": [[x * 100, y * 100, z] for x, y, z in CUBE]},
        {"transform": {"scale": [1, 1]}},
        {"CityObjects": []},
        {"CityObjects": {"street": {"type": "Road"}}},
    ],
)
def test_what_cannot_be_placed_is_refused_in_one_sentence(read, change, refuses):
    with refuses():
        read({**city(), **change})


def test_the_user_may_say_what_the_file_does_not(read):
    for metadata, choices in (
        ({}, {"crs": "EPSG:7415"}),
        ({"referenceSystem": "EPSG:28992"}, {"altitudes": "amsl"}),
    ):
        (house,) = read(city(metadata=metadata), **choices)
        assert house.high == sky.AboveSea(7.5)


def places_in(value, path=()):
    yield path
    inner = value.items() if isinstance(value, dict) else enumerate(value[:2]) if isinstance(value, list) else ()
    for key, one in inner:
        yield from places_in(one, (*path, key))


@pytest.mark.parametrize("wrong", [None, True, "x", -1, 3, 1e300, 10**400, [], {}, [[]], [None], {"a": 1}, "\ud800"])
def test_a_wrong_type_at_any_place_of_the_file_is_read_or_refused_in_one_sentence(tmp_path, wrong):
    path = tmp_path / "city.json"
    whole = city({"a": {"type": "Building", "attributes": {"height": 3}, "geometry": [surfaces(FACES[:2])]}})
    refusals = 0
    for place in places_in(whole):
        document = copy.deepcopy(whole)
        holder = document
        for key in place[:-1]:
            holder = holder[key]
        if place:
            holder[place[-1]] = wrong
        path.write_text(json.dumps(document if place else wrong))
        try:
            found = read_file(path)
        except sky.InputError as error:
            found = []
            refusals += str(path) in str(error)
        assert all(shapely.Polygon(one.outline, one.holes).is_valid for one in found)
    assert refusals > 10


@needs_data
def test_delft_has_its_160_buildings_within_the_extent_that_it_states():
    document = json.loads((DATA / "delft.city.json").read_text())
    found = read_file(DATA / "delft.city.json")
    assert len(found) == len({one.where for one in found}) == 160 + 126 + 3
    assert [one.kind for one in found].count("building") == 160
    x0, y0, z0, x1, y1, z1 = document["metadata"]["geographicalExtent"]
    whole = shapely.union_all([flat(one) for one in found])
    assert shapely.box(x0 - 0.01, y0 - 0.01, x1 + 0.01, y1 + 0.01).covers(whole)
    assert all(z0 - 1e-6 <= one.low.metres < one.high.metres <= z1 + 1e-6 for one in found)


@needs_data
@pytest.mark.parametrize(("name", "crs"), [("delft.city.json", None), ("rotterdam.city.json", "EPSG:7415")])
def test_every_corner_of_every_building_lies_in_what_was_made_of_it(name, crs):
    document = json.loads((DATA / name).read_text())
    transform = document["transform"]
    vertices = np.array(document["vertices"]) * transform["scale"] + transform["translate"]
    found = {}
    for one in read_file(DATA / name, crs=crs):
        found.setdefault(one.name, []).append(one)
    for number, ones in found.items():
        used = json.dumps(document["CityObjects"][number]["geometry"][0]["boundaries"])
        corners = vertices[[int(n) for n in used.replace("[", " ").replace("]", " ").replace(",", " ").split()]]
        whole = shapely.union_all([flat(one) for one in ones]).buffer(0.003)
        assert shapely.covers(whole, shapely.points(corners[:, :2])).all()
        assert ones[0].low.metres == pytest.approx(corners[:, 2].min())
        assert ones[0].high.metres == pytest.approx(corners[:, 2].max())
    taken = ("Building", "Bridge", "PlantCover")
    assert len(found) == sum(one["type"] in taken for one in document["CityObjects"].values())
