"""Whatever is wrong with what a survey is made of is refused in one sentence that names it, with exit code 2."""

import json
import re

import numpy as np
import pytest

import skyverse as sky

HERE = (9.85, 46.80)
SIZE = 0.003
SQUARE = [(0, 0), (1, 0), (1, 1), (0, 1), (0, 0)]
CAMERA = {"sensor": [17.3, 13.0], "image": [5280, 3956], "focal": 12.29, "min_interval": 0.7}
ASKED = {"camera": "mavic-3e", "gsd": "3 cm", "ground": "1500 m amsl"}


def on_globe(ring):
    """Longitude and latitude of corners that are given as shares of a field."""
    return [(HERE[0] + SIZE * x, HERE[1] + SIZE * y) for x, y in ring]


def kml(*rings, of=None):
    """A KML file of a polygon's rings, or of something else."""
    loops = [
        f"<LinearRing><coordinates>{' '.join(f'{x},{y},0' for x, y in ring)}</coordinates></LinearRing>"
        for ring in rings
    ]
    sides = ["outerBoundaryIs"] + ["innerBoundaryIs"] * len(loops)
    within = "".join(f"<{side}>{loop}</{side}>" for side, loop in zip(sides, loops, strict=False))
    placed = f"<Placemark><name>field</name>{of or f'<Polygon>{within}</Polygon>'}</Placemark>"
    return f'<kml xmlns="http://www.opengis.net/kml/2.2">{placed}</kml>'


def geojson(kind, coordinates, **more):
    geometry = {"type": kind, "coordinates": coordinates}
    return json.dumps({"type": "FeatureCollection", "features": [{"type": "Feature", "geometry": geometry}]} | more)


def camera(**changes):
    return json.dumps({name: value for name, value in (CAMERA | changes).items() if value is not None})


def grid(heights, corner=None, cell=0.0005):
    """An ESRI ASCII grid about the field."""
    heights = np.asarray(heights, dtype=float)
    x, y = corner or (HERE[0] - 0.005, HERE[1] - 0.005)
    head = f"ncols {heights.shape[1]}\nnrows {heights.shape[0]}\nxllcorner {x}\nyllcorner {y}\ncellsize {cell}\n"
    return head + "NODATA_value -9999\n" + "\n".join(" ".join(f"{h:g}" for h in row) for row in heights)


FIELD = kml(on_globe(SQUARE))
OUTLINES = {
    "crosses itself": ([(0, 0), (1, 1), (1, 0), (0, 1), (0, 0)], "cross or touch itself"),
    "touches itself": ([(0, 0), (1, 0), (0.5, 0.5), (1, 1), (0, 1), (0.5, 0.5), (0, 0)], "cross or touch itself"),
    "a hairline": ([(0, 0), (1, 0), (1, 1e-8), (0, 1e-8), (0, 0)], "encloses nothing|hairline"),
    "a sliver": ([(0, 0), (1, 0.0001), (1, 0.0002), (0, 0)], "hairline"),
    "on one line": ([(0, 0), (0.5, 0), (1, 0), (0, 0)], "hairline"),
    "one place": ([(0, 0), (0, 0), (0, 0), (0, 0)], "fewer than three corners"),
    "a spur": ([(0, 0), (1, 0), (1, 1), (1, 2), (1, 1), (0, 1), (0, 0)], "cross or touch itself"),
}
FILES = {
    **{name: ("field.kml", kml(on_globe(ring)), said) for name, (ring, said) in OUTLINES.items()},
    "two corners": ("field.kml", kml(on_globe(SQUARE[:2])), "corners|ring|points"),
    "a hole outside": ("field.kml", kml(on_globe(SQUARE), on_globe([(x + 3, y) for x, y in SQUARE])), "outside"),
    "latitude first": ("field.kml", kml([(y, x + 100) for x, y in on_globe(SQUARE)]), "latitude|longitude"),
    "no number": ("field.kml", FIELD.replace("9.853", "nine"), "number|coordinate"),
    "NaN": ("field.kml", FIELD.replace("9.853", "nan"), "number|coordinate|finite"),
    "a decimal comma": ("field.kml", FIELD.replace("9.853", "9;853"), "number|coordinate"),
    "no polygon": ("field.kml", kml(of="<Point><coordinates>9.85,46.8,0</coordinates></Point>"), "polygon"),
    "a line": (
        "field.kml",
        kml(of="<LineString><coordinates>9.85,46.8,0 9.86,46.8,0</coordinates></LineString>"),
        "expected a polygon, found a line",
    ),
    "nothing in it": ("field.kml", '<kml xmlns="http://www.opengis.net/kml/2.2"></kml>', "found nothing"),
    "an empty file": ("field.kml", "", "KML|XML|empty|element"),
    "half a file": ("field.kml", FIELD[: len(FIELD) // 2], "KML|XML|tag|element|closed"),
    "no KML": ("field.kml", "corners: 1, 2, 3", "KML|XML|syntax"),
    "another ending": ("field.dwg", FIELD, "expected a file of areas"),
    "no JSON": ("field.geojson", "{", "JSON"),
    "another JSON": ("field.geojson", '{"format": "skyverse"}', "GeoJSON|type"),
    "a GeoJSON line": ("field.geojson", geojson("LineString", on_globe(SQUARE)), "expected a polygon, found a line"),
    "GeoJSON in metres": (
        "field.geojson",
        geojson("Polygon", [[(2_780_000 + 900 * x, 1_180_000 + 900 * y) for x, y in SQUARE]]),
        "longitude|latitude|degrees",
    ),
    "GeoJSON without places": ("field.geojson", geojson("Polygon", [[]]), "nothing|corner|ring|coordinates|empty"),
    "GeoJSON with null": (
        "field.geojson",
        geojson("Polygon", [[(None, 1), (2, 3), (4, 5), (None, 1)]]),
        "expected longitude and latitude, found",
    ),
    "over a pole": (
        "field.geojson",
        geojson("Polygon", [[(0, 89.9), (90, 89.9), (180, 89.9), (270, 89.9), (0, 89.9)]]),
        "pole|longitude|globe",
    ),
    "two far apart": (
        "field.geojson",
        geojson("MultiPolygon", [[on_globe(SQUARE)], [[(x + 3, y) for x, y in on_globe(SQUARE)]]]),
        "km",
    ),
    "as large as a country": ("field.kml", kml([(HERE[0] + 2 * x, HERE[1] + 2 * y) for x, y in SQUARE]), "km"),
}
OPTIONS = {
    "no camera of this name": ({"camera": "mavik-3e"}, "mavic-3e"),
    "an own camera without units": ({"camera": "13.2x8.8, 5472x3648, 8.8"}, "--camera: expected sensor.*13.2x8.8 mm"),
    "an own camera of oblong pixels": ({"camera": "13.2x8.8 mm, 5472x2000 px, 8.8 mm"}, "--camera: .*square"),
    "an own camera of an equivalent focal length": ({"camera": "13.2x8.8 mm, 5472x3648, 240 mm"}, "--camera: focal"),
    "no ground": ({"ground": None}, "--terrain: expected .*--ground"),
    "minutes of a vehicle of unknown power": ({"vehicle": "mapping", "battery": "20 min"}, "--battery: .*--vehicle"),
    "no unit of the battery": ({"battery": "20"}, "--battery: expected minutes"),
    "an empty battery": ({"battery": "0 min"}, "--battery: expected minutes"),
    "an overlap of 100": ({"overlap": "100,70"}, "overlap.*95"),
    "one overlap": ({"overlap": "80"}, "--overlap"),
    "overlaps as shares of one": ({"overlap": "0.8,0.7"}, "overlap.*per cent"),
    "a negative overlap": ({"overlap": "-5,70"}, "overlap"),
    "a GSD without meaning": ({"gsd": "fine"}, "gsd.*'2 cm'"),
    "a GSD of nought": ({"gsd": "0 cm"}, "gsd"),
    "a negative GSD": ({"gsd": "-2 cm"}, "gsd"),
    "a GSD in inches": ({"gsd": "1 in"}, "gsd.*'2 cm'"),
    "a GSD from below the clearance": ({"gsd": "5 mm"}, "--gsd: .*clearance"),
    "a GSD from beyond the ceiling": ({"gsd": "50 cm", "max-height": "20 m agl"}, "max_height"),
    "both a GSD and a height": ({"height": "60"}, "gsd or height"),
    "a direction beyond the compass": ({"direction": "400"}, "direction"),
    "a gimbal that looks up": ({"gimbal": "60"}, "gimbal"),
    "a gimbal at the horizon": ({"gimbal": "0"}, "gimbal|horizon"),
    "a negative margin": ({"margin": "-3"}, "margin"),
    "a corridor without width": ({"pattern": "corridor"}, "polygon|line|width"),
    "a width of strips": ({"width": "30"}, "width"),
    "no drones": ({"drones": "0"}, "drones"),
    "a launch far away": ({"launch": "48.1,11.5"}, "km|launch"),
    "a fence that is the field itself": ({"fence": "field.kml"}, "--launch: .*give --launch .* inside the fence"),
    "a launch without longitude": ({"launch": "46.8"}, "--launch"),
    "another pattern": ({"pattern": "spiral"}, "spiral"),
    "a facade of an area": ({"pattern": "facade"}, "--buildings and --structure"),
}
CAMERAS = {
    "an equivalent focal length": ({"focal": 240.0}, "focal"),
    "a focal length of nought": ({"focal": 0.0}, "focal"),
    "pixels that are not square": ({"image": [5280, 2000]}, "square"),
    "an interval of nought": ({"min_interval": 0.0}, "min_interval"),
    "no interval": ({"min_interval": None}, "min_interval"),
    "no sensor": ({"sensor": None}, "sensor"),
    "a sensor in metres": ({"sensor": [0.0173, 0.013]}, "sensor|focal"),
    "a key that is not known": ({"fov": 84}, "fov"),
    "no numbers": ({"image": "20 MP"}, "image"),
}
TERRAINS = {
    "ground beyond the raster": (grid(np.full((4, 4), 1500.0), corner=(9.80, 46.80)), "dem.asc|ground|terrain|raster"),
    "a hole in the raster": (
        grid(np.where(np.hypot(*np.mgrid[-12:13, -12:13]) < 6, -9999, 1500.0)),
        "dem.asc|nodata|height|ground|terrain",
    ),
    "no numbers in the raster": ("ncols 3\nnrows 3\nhello", "dem.asc"),
}


def words_of(**changes):
    """The options of a survey, some of them changed; those that are None are left out."""
    asked = ASKED | changes
    return [f"--{name}={value}" for name, value in asked.items() if value is not None]


def cases():
    for name, (file, text, said) in FILES.items():
        yield f"file: {name}", [file, *words_of()], {file: text}, said
    for name, (changes, said) in OPTIONS.items():
        yield f"option: {name}", ["field.kml", *words_of(**changes)], {"field.kml": FIELD}, said
    for name, (changes, said) in CAMERAS.items():
        files = {"field.kml": FIELD, "mine.json": camera(**changes)}
        yield f"camera: {name}", ["field.kml", *words_of(camera="mine.json")], files, f"mine.json.*({said})"
    for name, (text, said) in TERRAINS.items():
        words = words_of(ground=None, terrain="dem.asc", **{"terrain-crs": "EPSG:4326", "terrain-unit": "m"})
        yield f"terrain: {name}", ["field.kml", *words], {"field.kml": FIELD, "dem.asc": text}, said


CASES = {name: rest for name, *rest in cases()}


def test_there_are_many_cases():
    assert len(CASES) >= 60


@pytest.mark.parametrize(("words", "files", "said"), CASES.values(), ids=CASES)
def test_what_is_malformed_is_refused_in_one_sentence(skyverse, tmp_path, words, files, said):
    for name, text in files.items():
        (tmp_path / name).write_text(text)
    code, out, err = skyverse("survey", *words, "-o", "out/field.json")
    assert (code, out) == (2, ""), err
    *notes, sentence = err.splitlines()
    told = ("UAVs may stray", "UAVs stay inside the fence", "skyverse: compiling")
    assert all(note.startswith(told) for note in notes)
    assert re.search(said, sentence), sentence
    assert not (tmp_path / "out").exists()


@pytest.mark.parametrize("words", [[], ["--launch=46.8003,9.8509"]])
@pytest.mark.parametrize(("names", "said"), [(["nosuch"], "'nosuch'"), (["hall", "hal"], "'hal'.*'hall'")])
def test_a_structure_that_is_not_there_is_refused(skyverse, tmp_path, names, said, words):
    hall = {"type": "Feature", "properties": {"name": "hall", "height": 9}}
    hall["geometry"] = {"type": "Polygon", "coordinates": [on_globe([(0.2 * x, 0.2 * y) for x, y in SQUARE])]}
    (tmp_path / "town.geojson").write_text(json.dumps({"type": "FeatureCollection", "features": [hall]}))
    words = [*words, *(f"--structure={name}" for name in names), *words_of(buildings="town.geojson", pattern="facade")]
    code, out, err = skyverse("survey", *words, "--unit=m", "--altitudes=agl", "-o", "out/field.json")
    assert (code, out) == (2, ""), err
    assert re.search(f"--structure: .*{said}", err.splitlines()[-1]), err


def test_parts_of_several_files_that_overlap_are_seen_once(skyverse, tmp_path):
    for name, shift in {"west.kml": 0.0, "east.kml": 0.5}.items():
        (tmp_path / name).write_text(kml(on_globe([(0.3 * (x + shift), 0.3 * y) for x, y in SQUARE])))
    code, _, err = skyverse("survey", "west.kml", "east.kml", *words_of(), "-o", "out/field.json", "--no-page")
    assert code in (0, 1), err
    (part,) = sky.read_mission(tmp_path / "out" / "field.json").scenario.surveys[0].area
    assert np.ptp(part.vertices, axis=0) == pytest.approx((0.45 * 229, 0.3 * 333.5), rel=0.01)
