"""Files of zones that tests write, and what reading them ends in."""

import shapely

import skyverse as sky
from skyverse.maps.georeference.reading import Choices
from skyverse.maps.readers import read_features

SQUARE = [[7.0, 47.0], [7.001, 47.0], [7.001, 47.001], [7.0, 47.001], [7.0, 47.0]]
COURT = [[7.0004, 47.0004], [7.0006, 47.0004], [7.0006, 47.0006], [7.0004, 47.0006], [7.0004, 47.0004]]
ZONE = {"lower": "0 m agl", "upper": "120 m agl"}


def feature(rings=(SQUARE,), kind="Polygon", **fields):
    return {"type": "Feature", "properties": fields or ZONE, "geometry": {"type": kind, "coordinates": list(rings)}}


def collection(*features, **more):
    return {"type": "FeatureCollection", "features": list(features), **more}


def polygon(one):
    return shapely.Polygon(one.outline, one.holes)


def read_file(path, **choices):
    """Return the buildings or zones of a file."""
    return read_features(path, Choices(**choices))


def outcome(path, **choices):
    """Return what is read, or the one sentence that it ends in."""
    try:
        return read_file(path, **choices), ""
    except sky.InputError as error:
        return None, str(error)


def kml(*placemarks):
    return (
        '<?xml version="1.0" encoding="UTF-8"?><kml xmlns="http://www.opengis.net/kml/2.2"><Document><Folder>'
        + "".join(f"<Placemark>{one}</Placemark>" for one in placemarks)
        + "</Folder></Document></kml>"
    )


def kml_polygon(z=None, mode="", extrude="", inner=""):
    ring = " ".join(f"{x},{y}" + ("" if z is None else f",{z}") for x, y in SQUARE)
    outer = f"<outerBoundaryIs><LinearRing><coordinates>\n{ring}\n</coordinates></LinearRing></outerBoundaryIs>"
    return f"<Polygon>{extrude}{mode}{outer}{inner}</Polygon>"


RELATIVE, ABSOLUTE = (f"<altitudeMode>{mode}</altitudeMode>" for mode in ("relativeToGround", "absolute"))


EXTRUDE = "<extrude>1</extrude>"
