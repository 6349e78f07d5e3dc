"""The ellipsoid around a UAV that another one must keep out of, wherever both are within their tracking errors."""

import numpy as np

from skyverse._typing import Floats
from skyverse.model.uav import UAV


def kept_ellipsoid(one: UAV, other: UAV) -> tuple[float, float]:
    """Return the semi-axes of the ellipsoid that two UAVs must keep out of, horizontal and vertical, metres."""
    xy, z = (np.array([max(pair)]) for pair in zip(one.ellipsoid, other.ellipsoid, strict=True))
    errors = one.tracking_error, other.tracking_error
    aside, up = sum(error.horizontal for error in errors), sum(error.vertical for error in errors)
    factor = 1.0 + strayed_share(xy, z, np.array([aside]), np.array([up]))
    return float((xy * factor)[0]), float((z * factor)[0])


def strayed_share(xy: Floats, z: Floats, aside: Floats, up: Floats) -> Floats:
    """Return by what share of itself an ellipsoid has to grow to hold what comes within an error of it.

    The error is an upright cylinder, which lies in an ellipsoid of the same shape through its rim. Two ellipsoids of
    one shape add up to a third of that shape.

    Parameters
    ----------
    xy, z
        Semi-axes of the ellipsoids, metres.
    aside, up
        The radius and half the height of the cylinder, metres.
    """
    rim = (np.divide(reach, axis, np.zeros_like(axis), where=axis > 0) for reach, axis in ((aside, xy), (up, z)))
    return np.hypot(*rim)
