"""What is said of starts in zones, of places far from the others, and of notes that explain a refusal."""

import json
import re

import pytest

pytest.importorskip("pyproj", reason="building scenarios needs pyproj")
pytest.importorskip("shapely", reason="building scenarios needs shapely")

import skyverse as sky
from of_maps import of_maps
from skyverse.space.unsafe_points import unsafe_points

RING = [[10.004, 49.996], [10.006, 49.996], [10.006, 50.004], [10.004, 50.004], [10.004, 49.996]]


def zones(folder, **fields):
    path = folder / "zones.geojson"
    shape = {"type": "Polygon", "coordinates": [RING]}
    feature = {"type": "Feature", "properties": {"name": "area", "reference": "AGL", **fields}, "geometry": shape}
    path.write_text(json.dumps({"type": "FeatureCollection", "features": [feature]}))
    return path


def built(folder, height, **fields):
    start = (50.0, 10.005, sky.AboveGround(height))
    path = zones(folder, **fields)
    return of_maps("z", ground=sky.AboveSea(300), uavs=[start], targets=[(50.0, 10.01, start[2])], zones=[path])


@pytest.mark.parametrize("height", [60, 240, 500])
@pytest.mark.parametrize("fields", [{"lower": "50 m", "upper": "920 m"}, {"lower": "50 m"}, {"upper": "UNL"}, {}])
def test_a_zone_above_the_bounds_has_no_roof(tmp_path, height, fields, refuses):
    with refuses():
        built(tmp_path, height, **fields)


def test_a_zone_below_the_ceiling_has_a_roof(tmp_path, refuses):
    with refuses():
        built(tmp_path, 110, upper="120 m")


HERE, THERE = (50.0, 10.0, sky.AboveGround(30)), (50.0, 10.01, sky.AboveGround(30))


@pytest.mark.parametrize("turned", ["a", "b", "t"])
def test_one_place_with_latitude_and_longitude_swapped_is_named(turned, refuses):
    uavs, targets = {"a": HERE, "b": (50.001, 10.0, sky.AboveGround(30))}, {"t": THERE}
    for places in (uavs, targets):
        if turned in places:
            latitude, longitude, altitude = places[turned]
            places[turned] = (longitude, latitude, altitude)
    with refuses():
        of_maps("z", ground=sky.AboveSea(300), uavs=uavs, targets=targets)


def test_of_two_places_either_may_be_swapped(refuses):
    with refuses():
        of_maps("z", ground=sky.AboveSea(300), uavs={"a": HERE}, targets={"t": (10.01, 50.0, sky.AboveGround(30))})


def test_places_that_are_far_apart_either_way_are_not_called_swapped(refuses):
    with refuses():
        of_maps("z", ground=sky.AboveSea(300), uavs={"a": HERE}, targets={"t": (20.0, 30.0, sky.AboveGround(30))})


def test_notes_are_printed_with_the_refusal_that_they_may_explain(tmp_path, capsys):
    from skyverse.cli import main

    ends = ["--uav", "50.0,10.005,60 m agl", "--target", "50.0,10.01,60 m agl"]
    words = ["--ground", "300 m amsl", "--zones", str(zones(tmp_path)), "-o", str(tmp_path / "z.yaml")]
    with pytest.raises(SystemExit, match="2"):
        main(["scenario", "build", *words, *ends])
    *notes, refusal = capsys.readouterr().err.splitlines()
    assert any("1 without limits: shut from the ground up" in note for note in notes)
    assert "reaches above the bounds" in refusal


def test_places_far_away_are_told_in_metres_without_powers_of_ten():
    wall = sky.Box(min=(0, 0, 0), max=(3999, 4000, 100))
    scenario = sky.Scenario(
        name="wide",
        bounds={"min": (0, 0, 0), "max": (4000, 4000, 100)},
        obstacles=[wall],
        lattice={"step": (50, 50, 50)},
        clearance=0.5,
        uavs=[{"start": (2000, 2000, 50)}],
        targets=[{"position": (3999.8, 2000, 50)}],
    )
    (start,) = unsafe_points(scenario)
    assert re.search(r"[12],\d{3} m away", start.sentence)
