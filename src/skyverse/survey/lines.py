"""Photo lines: where a UAV flies to take the photos of a survey, before anybody says who flies them and when."""

from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from skyverse._typing import Floats
from skyverse.model.coverage import CoverageGap
from skyverse.numerics.tolerances import SAME_PLACE


@dataclass(frozen=True, eq=False)
class PhotoLine:
    """A way along which photos are taken.

    Attributes
    ----------
    survey
        The index of the survey.
    path
        (k, 3) metres, straight between the points; one point for a single photo.
    every
        Metres from one photo to the next, seen from above, a whole share of the way's length; 0 for a single photo.
    speed
        m/s: the fastest at which the camera keeps up, and over ground.
    pitch
        Degrees above the horizon at which the camera looks.
    heading
        Where the camera looks, or the top of a picture that is taken straight down, degrees clockwise from north;
        ``None`` where the UAV flies to.
    both_ways
        Whether it may be flown from its end as well.
    stay
        Seconds for which the UAV stands still at each photo; 0 where it flies through.
    """

    survey: int
    path: Floats
    every: float
    speed: float
    pitch: float = -90.0
    heading: float | None = None
    both_ways: bool = True
    stay: float = 0.0

    @property
    def parts(self) -> list[Floats]:
        """The ways from one photo to the next, (k, 3) metres each."""
        level = np.hypot(*np.diff(self.path[:, :2], axis=0).T)
        at = np.r_[0.0, np.cumsum(level)]
        photos = np.linspace(0.0, at[-1], round(at[-1] / self.every) + 1)
        stops = np.stack([np.interp(photos, at, self.path[:, axis]) for axis in range(3)], axis=1)
        inner = [self.path[(at > a + SAME_PLACE) & (at < b - SAME_PLACE)] for a, b in pairwise(photos)]
        return [np.vstack([a, way, b]) for (a, b), way in zip(pairwise(stops), inner, strict=True)]


@dataclass(frozen=True, eq=False)
class SurveyLines:
    """The lines of a survey, and the parts of it that none of them sees, with why."""

    lines: tuple[PhotoLine, ...]
    unseen: tuple[CoverageGap, ...] = ()
