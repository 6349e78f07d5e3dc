"""All starts and targets that cannot be where they are, named at once; the free places that are told are free."""

import json
import re

import numpy as np
import pytest

pytest.importorskip("pyproj", reason="building scenarios needs pyproj")
pytest.importorskip("shapely", reason="building scenarios needs shapely")

from skyverse.errors import InputError
from skyverse.maps.assembly.build import build_scenario
from skyverse.model.altitude import AboveGround, AboveSea, parse_altitude

LAT, LON = 46.8, 9.85
DEGREE = 111_200.0


def place(east, north, altitude):
    return LAT + north / DEGREE, LON + east / (DEGREE * np.cos(np.radians(LAT))), altitude


@pytest.fixture
def halls(tmp_path):
    """Two halls, 20 m and 12 m high, each 100 m wide, at (0, 0) and (300, 0)."""
    features = []
    for name, east, height in (("big hall", 0, 20), ("small hall", 300, 12)):
        ring = [place(east + a, b, 0)[1::-1] for a, b in ((-50, -50), (50, -50), (50, 50), (-50, 50), (-50, -50))]
        shape = {"type": "Polygon", "coordinates": [ring]}
        features.append({"type": "Feature", "properties": {"name": name, "height": height}, "geometry": shape})
    path = tmp_path / "halls.geojson"
    path.write_text(json.dumps({"type": "FeatureCollection", "features": features}))
    return path


def built(halls, uavs, targets=()):
    given = {"buildings": [halls], "ground": AboveSea(500), "ceiling": AboveGround(100), "clearance": 2.0}
    return build_scenario("town", uavs=uavs, targets=targets, tolerance=0, area=(9.84, 46.79, 9.87, 46.81), **given)


GOOD = place(-200, 0, AboveGround(30))


def test_all_bad_points_are_named_with_roof_and_free_place(halls):
    uavs = {
        "a": place(40, 0, AboveGround(10)),
        "b": GOOD,
        "c": place(300, 0, AboveGround(11)),
        "d": place(-300, 0, AboveGround(1)),
        "e": place(-300, 50, AboveGround(130)),
    }
    with pytest.raises(InputError) as refused:
        built(halls, uavs)
    heading, *lines = str(refused.value).splitlines()
    assert heading == "4 starts and targets cannot be where they are:"
    assert [line.split(":")[0].strip() for line in lines] == ["d", "e", "a", "c"]
    assert "expected a point at least 2 m above the ground, found it 1.00 m above the ground" in lines[0]
    assert "expected a point below the ceiling, found it 30.0 m above" in lines[1]
    assert "the building 'big hall' of halls.geojson, whose roof is at 520.0 m amsl (20.0 m agl)" in lines[2]
    assert "the building 'small hall' of halls.geojson, whose roof is at 512.0 m amsl (12.0 m agl)" in lines[3]
    free = {}
    for name, line in zip("deac", lines, strict=True):
        said = re.search(r"nearest free place is ([-\d.]+),([-\d.]+),([\d.]+ m agl), ([\d.]+) m away", line)
        free[name] = (float(said[1]), float(said[2]), parse_altitude(said[3]))
        assert float(said[4]) < {"d": 1.2, "e": 30.4, "a": 12.5, "c": 3.4}[name]
    assert len(built(halls, uavs | free).uavs) == 5  # as told, they are all free


def test_one_bad_point_is_one_sentence(halls):
    sentence = r"\Atarget-1: expected a point 2 m or more from what .* agl\); the nearest [^\n]*\Z"
    with pytest.raises(InputError, match=sentence):
        built(halls, [GOOD], [place(0, 0, AboveGround(10))])


def test_all_places_outside_the_area_are_named(halls):
    with pytest.raises(InputError) as refused:
        built(halls, {"far": place(0, 9000, AboveGround(30)), "b": GOOD}, {"away": place(9000, 0, AboveGround(30))})
    heading, *lines = str(refused.value).splitlines()
    assert heading == "2 starts and targets cannot be where they are:"
    assert lines[0].startswith("  far: expected a place in the area, which ends ")
    assert lines[1].startswith("  away: expected a place in the area, which ends ")
