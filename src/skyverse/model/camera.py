"""Cameras: what a picture taken from a distance shows, and how finely; cameras by name, with their sources."""

import math
import re
from types import MappingProxyType
from typing import Annotated, Literal, Self

from pydantic import BeforeValidator, Field, model_validator

from skyverse.errors import did_you_mean, shown
from skyverse.model.quantities import Flag, Model, NonNegative, Positive, Whole, listed

MOST_UNSQUARE = 0.03
"""The share by which the sides of a pixel may differ: more is a wrong entry, not a camera."""
FOCAL_SHARES = (0.3, 5.0)
"""The focal length of real cameras of UAVs, as multiples of their sensor's diagonal."""

Millimetres = Annotated[tuple[Positive, Positive], BeforeValidator(listed)]
Pixels = Annotated[tuple[Annotated[Whole, Field(gt=0)], Annotated[Whole, Field(gt=0)]], BeforeValidator(listed)]


class Camera(Model):
    """A camera with a rectangular sensor and a lens without distortion.

    Attributes
    ----------
    name
        What it is called.
    sensor
        Width and height of the sensor, mm.
    image
        Width and height of the picture, pixels.
    focal
        The true focal length, mm, not that of a 35 mm camera with the same view.
    min_interval
        Seconds from one photo to the next at least.
    shutter
        Whether it reads the picture line by line (``"rolling"``) or all at once (``"global"``, also mechanical ones).
    portrait
        Whether the width of the picture lies along the flight, and not across it.
    attitude_error
        Degrees by which the direction in which the gimbal holds the camera may be off.
    """

    name: str = ""
    sensor: Millimetres
    image: Pixels
    focal: Positive
    min_interval: Positive
    shutter: Literal["rolling", "global"] = "global"
    portrait: Flag = False
    attitude_error: Annotated[NonNegative, Field(le=10)] = 1.0

    @model_validator(mode="after")
    def _real(self) -> Self:
        wide, high = (a / b for a, b in zip(self.sensor, self.image, strict=True))
        if abs(wide / high - 1.0) > MOST_UNSQUARE:
            raise ValueError(
                f"sensor and image must have square pixels, but they are {1e3 * wide:.3g} and {1e3 * high:.3g} "
                "micrometres wide and high"
            )
        share = self.focal / math.hypot(*self.sensor)
        if not FOCAL_SHARES[0] <= share <= FOCAL_SHARES[1]:
            raise ValueError(
                f"focal must be the true focal length, {FOCAL_SHARES[0]:g} to {FOCAL_SHARES[1]:g} times the sensor's "
                f"diagonal, but it is {share:.3g} times that"
            )
        return self

    @property
    def pixel(self) -> float:
        """The larger side of a pixel divided by the focal length: metres on the ground for each metre of distance."""
        return max(a / b for a, b in zip(self.sensor, self.image, strict=True)) / self.focal

    @property
    def half_widths(self) -> tuple[float, float]:
        """Half of what a picture shows, across the flight and along it, for each metre of distance."""
        wide, high = (side / (2.0 * self.focal) for side in self.sensor)
        return (high, wide) if self.portrait else (wide, high)

    def gsd(self, distance: float) -> float:
        """Return the ground sample distance, metres, of what is at a distance along the optical axis, metres."""
        return distance * self.pixel

    def distance(self, gsd: float) -> float:
        """Return the distance along the optical axis, metres, at which a pixel shows so many metres."""
        return gsd / self.pixel


def _camera(name: str, sensor: Millimetres, image: Pixels, focal: float, interval: float, shutter: str) -> Camera:
    fields = {"sensor": sensor, "image": image, "focal": focal, "min_interval": interval, "shutter": shutter}
    return Camera(name=name, **fields)


CAMERAS = MappingProxyType(
    {
        camera.name: camera
        for camera in (
            _camera("mini-4-pro", (9.6, 7.2), (8064, 6048), 6.72, 5.0, "rolling"),
            _camera("mini-4-pro-12mp", (9.6, 7.2), (4032, 3024), 6.72, 2.0, "rolling"),
            _camera("mini-3-pro", (9.6, 7.2), (8064, 6048), 6.72, 5.0, "rolling"),
            _camera("air-3", (9.6, 7.2), (8064, 6048), 6.72, 5.0, "rolling"),
            _camera("mavic-3e", (17.3, 13.0), (5280, 3956), 12.29, 0.7, "global"),
            _camera("mavic-3m", (17.3, 13.0), (5280, 3956), 12.29, 0.7, "global"),
            _camera("mavic-3t", (6.4, 4.8), (8000, 6000), 4.4, 2.0, "rolling"),
            _camera("phantom-4-pro", (13.2, 8.8), (5472, 3648), 8.8, 2.5, "global"),
            _camera("phantom-4-rtk", (13.2, 8.8), (5472, 3648), 8.8, 2.5, "global"),
            _camera("zenmuse-p1-35", (35.9, 24.0), (8192, 5460), 35.0, 0.7, "global"),
            _camera("zenmuse-l2", (17.3, 13.0), (5280, 3956), 12.29, 0.7, "global"),
            _camera("rx1r-ii", (35.9, 24.0), (7952, 5304), 35.0, 1.0, "global"),
            _camera("a6000-16", (23.5, 15.6), (6000, 4000), 16.0, 1.0, "global"),
            _camera("rededge-m", (4.8, 3.6), (1280, 960), 5.4, 1.0, "global"),
            _camera("altum", (7.16, 5.35), (2064, 1544), 8.0, 1.0, "global"),
            _camera("evo-ii-pro", (13.2, 8.8), (5472, 3648), 10.6, 2.0, "rolling"),
            _camera("anafi-usa", (6.17, 4.63), (5344, 4016), 4.0, 1.0, "rolling"),
            _camera("soda", (12.75, 8.5), (5472, 3648), 10.6, 1.5, "global"),
            _camera("sentera-65r", (29.9, 22.4), (9344, 7000), 27.4, 0.3, "global"),
        )
    }
)
"""Cameras by name. The numbers are those on which public catalogues agree; docs/survey.md names them, and doubts."""


_NUMBER = r"\s*(\d+(?:\.\d+)?)\s*"
_OWN = re.compile(rf"{_NUMBER}x{_NUMBER}mm\s*,\s*(\d+)\s*x\s*(\d+)\s*(?:px)?\s*,{_NUMBER}mm\s*(?:,{_NUMBER}s\s*)?")
OWN_CAMERA = "13.2x8.8 mm, 5472x3648 px, 8.8 mm, 2.5 s"
"""How a camera of one's own is written: its sensor, picture, focal length, and seconds between photos."""


def camera_of(given: object) -> object:
    """Return the camera of a name, or of what `OWN_CAMERA` shows, and anything else as it is.

    Without seconds between photos they are those of the slowest of `CAMERAS`.
    """
    if not isinstance(given, str):
        return given
    if "," in given:
        own = _OWN.fullmatch(given)
        if own is None:
            raise ValueError(f"expected sensor, picture and focal length, as in {OWN_CAMERA!r}, found {shown(given)}")
        wide, high, across, along, focal, seconds = own.groups()
        interval = seconds or max(camera.min_interval for camera in CAMERAS.values())
        fields = {"sensor": (float(wide), float(high)), "image": (int(across), int(along)), "focal": float(focal)}
        return Camera(**fields, min_interval=float(interval))
    if given not in CAMERAS:
        known = ", ".join(CAMERAS)
        raise ValueError(f"no camera is called {shown(given)}{did_you_mean(given, CAMERAS)}; there are {known}")
    return CAMERAS[given]
