"""The only reasons for which a test may be skipped, by cause; a skip for any other reason counts as a failure."""

import re

REASONS = {
    "a package is not installed": [
        r"could not import '[\w.]+': No module named '[\w.]+'",
        r".* is not installed(; pip install .*)?",
        r"needs (skyverse\[\w+\]|the extra: pip install '.*')",
        r'pip install "skyverse\[\w+\]"',
        r"the peers need the extra optimisers",
        r"(reading|building) [\w ]+ needs (rasterio|pyproj|shapely|pyogrio|pymavlink)",
        r"reads (KML|GPX|GeoJSON|what GDAL hands on|\.plan and \.waypoints|\.waypoints|\.litchi\.csv)",
        r"knows ROS messages|an independent geodesy|polygons are shapely's|the oracle is (PROJ|shapely)",
        r"this GDAL does not keep three-dimensional systems",
    ],
    "data is not there, which is not part of the repository": [
        r"the MovingAI benchmark is not at .*",
        r"needs (MovingAI's Simple\.3dmap|\.\./shared/data/[\w*.]+)",
        r"the (Davos terrain|terrain of Davos|Delft buildings|documentation) (is|are) not here",
        r"the thesis's tables as data are not here",
        r"the examples are in the repository only",
    ],
    "the last bits differ here": [r"this processor, C library or numpy rounds otherwise: .*"],
    "there is no browser": [r"no chromium to look at the page with"],
    "the platform is not POSIX": [
        r"Ctrl-C is a POSIX signal here|signals to a process are POSIX here",
        r"process groups are killed with POSIX signals|rights are POSIX ones",
    ],
    "kernels run as plain Python": [
        r"nothing is compiled|a benchmark of plain Python says nothing",
        r"planning thirty missions in plain Python is slow",
    ],
}


def cause_of(reason):
    """Return the cause that a skip's reason stands under, or None if it is not on the list."""
    text = reason.removeprefix("Skipped: ")
    for cause, patterns in REASONS.items():
        if any(re.fullmatch(pattern, text, re.DOTALL) for pattern in patterns):
            return cause
    return None
