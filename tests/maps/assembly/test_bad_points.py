"""All starts and targets that cannot be where they are, named at once; the free places that are told are free."""

import json
import re

import numpy as np
import pytest

import skyverse as sky

pytest.importorskip("pyproj", reason="building scenarios needs pyproj")
pytest.importorskip("shapely", reason="building scenarios needs shapely")

from of_maps import of_maps
from skyverse.cli.given_scenario import refuse_unsafe

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
        features.append({"type": "Feature", "properties": {"name": name, "height": f"{height} m"}, "geometry": shape})
    path = tmp_path / "halls.geojson"
    path.write_text(json.dumps({"type": "FeatureCollection", "features": features}))
    return path


def built(halls, uavs, targets=(), **more):
    given = {"buildings": [halls], "ground": sky.AboveSea(500), "ceiling": sky.AboveSea(600)} | more
    given = {"clearance": 2.0, "ground_clearance": 2.0} | given
    return of_maps("town", uavs=uavs, targets=targets, tolerance=0, area=(9.84, 46.79, 9.87, 46.81), **given)


GOOD = place(-200, 0, sky.AboveGround(30))


def test_all_bad_points_are_named_with_roof_and_free_place(halls):
    uavs = {
        "a": place(40, 0, sky.AboveGround(10)),
        "b": GOOD,
        "c": place(300, 0, sky.AboveGround(11)),
        "d": place(-300, 0, sky.AboveGround(1)),
        "e": place(-300, 50, sky.AboveGround(130)),
    }
    with pytest.raises(sky.InputError) as refused:
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
        said = re.search(r"a free place is ([-\d.]+),([-\d.]+),([\d.]+ m agl), ([\d.]+) m away", line)
        free[name] = (float(said[1]), float(said[2]), sky.parse_altitude(said[3]))
        assert float(said[4]) < {"d": 1.2, "e": 33.4, "a": 12.5, "c": 3.4}[name]
    assert len(built(halls, uavs | free).uavs) == 5  # as told, they are all free


def test_one_bad_point_is_one_sentence(halls, refuses):
    with refuses():
        built(halls, [GOOD], [place(0, 0, sky.AboveGround(10))])


def test_all_places_outside_the_area_are_named(halls):
    with pytest.raises(sky.InputError) as refused:
        built(
            halls,
            {"far": place(0, 9000, sky.AboveGround(30)), "b": GOOD},
            {"away": place(9000, 0, sky.AboveGround(30))},
        )
    heading, *lines = str(refused.value).splitlines()
    assert heading == "2 starts and targets cannot be where they are:"
    assert lines[0].startswith("  far: expected a place in the area; it ends ")
    assert lines[1].startswith("  away: expected a place in the area; it ends ")


def refused_lines(halls, uavs, targets=(), **more):
    with pytest.raises(sky.InputError) as refused:
        built(halls, uavs, targets, **more)
    return str(refused.value).splitlines()


def free_place(line):
    said = re.search(r"a free place is ([-\d.]+),([-\d.]+),([\d.]+ m a\w+), ([\d.]+) m away", line)
    return float(said[1]), float(said[2]), sky.parse_altitude(said[3])


TUBE = {"tracking_error": (2.0, 3.0), "separation": 5.0}


def test_points_from_which_uavs_would_stray_too_near_are_named_too(halls):
    uavs = {"high": place(-200, 0, sky.AboveGround(98)), "b": GOOD}
    targets = {"capped": place(-200, 90, sky.AboveGround(88))}
    heading, high, capped = refused_lines(halls, uavs, targets, max_height=sky.AboveGround(90), **TUBE)
    assert heading == "2 starts and targets cannot be where they are:"
    assert high.startswith("  high: expected a point at most 90 m above the ground, found it 98.00 m above;")
    assert "capped: expected a safe point, found one that reaches above the ceiling of 90 m" in capped
    assert free_place(capped)[2].metres == pytest.approx(86.9)
    moved = {"high": free_place(high), "b": GOOD}, {"capped": free_place(capped)}
    refuse_unsafe("town", built(halls, *moved, max_height=sky.AboveGround(90), **TUBE))


def test_starts_and_targets_nearer_than_the_separation_are_named(halls):
    near = place(-200, 4, sky.AboveGround(30))
    uavs = {"a": GOOD, "same": GOOD, "near": near, "far": place(-200, 100, sky.AboveGround(30))}
    targets = {"t": place(-300, 0, sky.AboveGround(40)), "u": place(-300, 3, sky.AboveGround(40))}
    heading, same, close, target = refused_lines(halls, uavs, targets, **TUBE)
    assert heading == "3 starts and targets cannot be where they are:"
    assert "same: expected a start at least 10 m from that of a at one height, or 20 m above or below it" in same
    assert "found it at the same place; a free place is " in same
    assert "near: expected a start" in close
    assert "found it 3.999 m away" in close
    assert "u: expected a target at least 10 m from that of t" in target
    moved = uavs | {"same": free_place(same), "near": free_place(close)}
    assert len(built(halls, moved, targets | {"u": free_place(target)}, **TUBE).uavs) == 4  # also from each other


def test_targets_may_be_close_where_not_all_are_flown_to(halls):
    targets = [place(-300, 0, sky.AboveGround(40)), place(-300, 3, sky.AboveGround(40))]
    assert len(built(halls, [GOOD], targets, **TUBE).targets) == 2


def test_the_free_place_is_told_with_an_altitude_counted_as_it_was_given(halls):
    lines = refused_lines(halls, [place(40, 0, sky.AboveSea(510)), place(0, 0, sky.AboveGround(10))])
    assert isinstance(free_place(lines[1])[2], sky.AboveSea)
    assert isinstance(free_place(lines[2])[2], sky.AboveGround)
