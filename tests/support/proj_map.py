"""Local metres by PROJ: an independent transverse Mercator."""

import numpy as np
import pytest


def proj_local(origin, latitude, longitude, altitude):
    """Return (n, 3) metres east and north on PROJ's map about an origin, and above it, of altitudes above the sea."""
    pyproj = pytest.importorskip("pyproj", reason="the oracle is PROJ")
    to_map = pyproj.Transformer.from_pipeline(
        "+proj=pipeline +step +proj=unitconvert +xy_in=deg +xy_out=rad "
        f"+step +proj=tmerc +ellps=WGS84 +lat_0={origin.latitude!r} +lon_0={origin.longitude!r}"
    )
    x, y = to_map.transform(np.asarray(longitude), np.asarray(latitude))
    return np.column_stack([x, y, np.broadcast_to(altitude, np.shape(x)) - origin.altitude])
