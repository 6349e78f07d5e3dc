"""A survey of the ground as it is flown: its passes, and how high and how near to each other photos are taken."""

import math
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from skyverse.errors import InputError
from skyverse.model.asked_ground import asked_ground
from skyverse.model.scenario import Scenario
from skyverse.model.survey import Survey
from skyverse.model.uav import UAV, TrackingError
from skyverse.space.agility import CLIMB_SHARE, agility_of, link_of
from skyverse.space.world import World
from skyverse.survey.crab import crab_angle, inscribed, overlap_to_plan
from skyverse.survey.flying import flying, greatest_error
from skyverse.survey.footprints import GroundView, Unsteady
from skyverse.survey.free_area import free_area
from skyverse.survey.ground import GroundCells, ground_cells
from skyverse.survey.spacing import (
    GroundSight,
    clear_heights,
)

CELLS_ALONG = 60
"""Cells of the ground along the shorter side of a photo."""
ROUGH_ALONG = 18
"""Those from which overlaps are found."""
SPARE = 0.004
"""By so much more than asked photos overlap, as the ground is looked at by places."""
STEEPEST = 1.0
"""Metres of height a metre: lines are nowhere steeper, whatever the UAVs can do."""
ROOM_ALONG = 40
"""Cells along the side of a square as large as the area, in which the heights are found that the ceiling allows."""
NEAREST = 1.0
"""Metres from which photos are taken at least."""


@dataclass(frozen=True)
class Pass:
    """Strips that are flown together.

    Attributes
    ----------
    pitch
        Degrees above the horizon at which the camera looks.
    turned
        Degrees clockwise from the direction of the strips of a survey; the camera looks ahead along it.
    """

    pitch: float
    turned: float


def passes_of(survey: Survey) -> tuple[Pass, ...]:
    """Return the passes of a pattern over an area."""
    if survey.pattern == "cross":
        return Pass(survey.pitch, 0.0), Pass(survey.pitch, 90.0)
    if survey.pattern == "oblique":
        return Pass(-90.0, 0.0), *(Pass(survey.pitch, turned) for turned in (0.0, 180.0, 90.0, 270.0))
    return (Pass(survey.pitch, 0.0),)


@dataclass(frozen=True)
class GroundSurvey:
    """A survey of the ground, and what all of its lines share."""

    scenario: Scenario
    number: int

    @property
    def survey(self) -> Survey:
        """What is to be seen."""
        return self.scenario.surveys[self.number]

    @cached_property
    def uavs(self) -> tuple[UAV, ...]:
        """Those that may fly it."""
        return flying(self.scenario, self.survey)

    @cached_property
    def error(self) -> TrackingError:
        """How far any of them may stray."""
        return greatest_error(self.uavs)

    @cached_property
    def wanted(self) -> Any:
        """The ground that is to be seen, a shapely geometry."""
        return asked_ground(self.survey)

    @cached_property
    def cells(self) -> GroundCells:
        """That ground, and what is around it."""
        return self._cells(CELLS_ALONG)

    @cached_property
    def rough(self) -> GroundCells:
        """The same in larger cells."""
        return self._cells(ROUGH_ALONG, touched=False)

    def _cells(self, along: int, *, touched: bool = True) -> GroundCells:
        distance = min(self.survey.distance, max(self.room, NEAREST))
        side = 2.0 * min(self.survey.camera.half_widths) * distance
        return ground_cells(self.scenario, self.wanted, side / along, 2.0 * distance, touched=touched)

    @cached_property
    def world(self) -> World:
        """What must be kept clear of."""
        return World(self.scenario, self.error)

    @cached_property
    def room(self) -> float:
        """Metres from most of the ground to the ceiling there."""
        cells = ground_cells(self.scenario, self.wanted, math.sqrt(self.wanted.area) / ROOM_ALONG, 0.0)
        wanted = np.argwhere(np.isfinite(cells.low))
        places = cells.origin + (wanted + 0.5) * cells.step
        _, ceiling = clear_heights(self.world.space, places, np.zeros_like(places), 0.0)
        return float(np.median(ceiling - cells.middle[tuple(wanted.T)]))

    @property
    def off(self) -> Unsteady:
        """By how much cameras may be off."""
        turned = math.radians(self.survey.camera.attitude_error)
        return Unsteady(math.sin(turned), self.error.horizontal, self.error.vertical)

    def sight(self, pitch: float) -> GroundSight:
        """Return how the ground is photographed by a camera that looks so many degrees above the horizon.

        Raises
        ------
        InputError
            It would see the horizon, or the ceiling is too low for the height that is asked for.
        """
        survey, off = self.survey, self.off
        across, along = survey.camera.half_widths
        c, s = math.cos(math.radians(pitch)), math.sin(math.radians(-pitch))
        highest = math.degrees(math.atan(along)) + survey.camera.attitude_error
        if -pitch <= highest + 1.0:
            raise InputError(
                f"expected a camera that sees no horizon, {-math.ceil(highest + 1.0):d} degrees or less above it, "
                f"found {pitch:g}",
                field="gimbal",
            )
        c = 0.0 if pitch == -90.0 else c
        front, beside = (share / 100.0 + SPARE * (share > 0) for share in survey.overlap)
        crab = crab_angle(self.uavs, self.scenario.wind)
        overlap = overlap_to_plan((front, beside), (across, along), crab)
        whole = survey.fine_all_over
        # how far from the optical axis what limits the height may be, for each metre of depth
        aside = math.hypot(across, along) if whole else math.hypot((1 - overlap[1]) * across, (1 - overlap[0]) * along)
        depth = survey.distance
        if survey.gsd is not None:
            stray = off.aside * c + off.up * s + math.hypot(off.aside, off.up) * off.sine
            depth = (depth - stray) / (math.sqrt(1.0 - off.sine**2) + aside * off.sine)
        elif survey.height is not None:
            if self.room < survey.height:
                most = math.floor(10.0 * self.room) / 10.0
                raise InputError(
                    f"expected {most:g} m or less, which the ceiling leaves above most of the ground and beside the "
                    f"tracking error, found {survey.height:g} m",
                    field="height",
                )
            depth = depth / s  # along the optical axis, where it meets level ground
        if depth <= 0.0:
            raise InputError("expected a camera that sees farther than UAVs stray", field="gsd")
        drop = depth * (s - along * c) if whole else depth * s
        lower = min(1.0, max(self.room, NEAREST) / drop)
        depth, drop = depth * lower, drop * lower
        far, near = drop * (c + along * s) / (s - along * c), drop * (c - along * s) / (s + along * c)
        photo = GroundView(depth, across, along, c, s, True, across * (far * c + drop * s), far, -near)
        least, most = drop / (s + along * c), drop / (s - along * c)
        # two photos ahead of each other do not share what is farthest; beside each other, they share the less the
        # narrower what they show is: at the border of what is to be seen, that is the nearer half of a photo
        middle = 0.5 * (far + near) if whole else drop * c / s
        alone = (far - near) * (least + most) / (2.0 * most), across * (least + middle * c + drop * s)
        # photos must overlap as asked, and what lies between two of them be seen however they are off
        shrink = [math.sqrt(1.0 + half * half) * math.hypot(1.0, across, along) * off.sine for half in (across, along)]
        certain = [
            2.0 * (least * (half - lost) - off.aside - off.up * half)
            for half, lost in zip((along, across), reversed(shrink), strict=True)
        ]
        if min(certain) <= 0.0:
            raise InputError(
                "expected photos that show more ground than UAVs stray, and than gimbals turn", field="gsd"
            )
        certain = inscribed(certain, crab)
        # over relief, too, photos share so much that all between them is seen for certain
        front, beside = (max(part, 1.0 - sure / size) for size, part, sure in zip(alone, overlap, certain, strict=True))
        overlap = front, beside
        steps = [size * (1.0 - share) for size, share in zip(alone, overlap, strict=True)]
        limit = photo
        if survey.gsd is None or (survey.pattern == "oblique" and c > 0.0 and not whole):
            # above the ground below: the photos that look straight down show all of it finely enough
            limit = photo._replace(
                whole=False, beside=0.0, before=0.0, behind=0.0, level=0.0, down=1.0, depth=depth * s
            )
        elif not whole:
            aside, ahead = 0.5 * steps[1], 0.5 * steps[0]
            limit = photo._replace(whole=False, beside=aside, before=middle + ahead, behind=ahead - middle)
        free = free_area(self.scenario, self.error, self.cells, limit)
        return GroundSight(
            self.cells,
            self.rough,
            limit,
            photo,
            (steps[0], steps[1]),
            overlap,
            free,
            self.world,
            self.steepest,
            max(map(link_of, self.wings), default=0.0),
        )

    @cached_property
    def wings(self) -> tuple[UAV, ...]:
        """Those of them that are aeroplanes."""
        return tuple(uav for uav in self.uavs if uav.fixed_wing is not None)

    @property
    def steepest(self) -> float:
        """Metres of height a metre that all UAVs can climb and descend; multirotors fly as slowly as that takes."""
        return min([STEEPEST, *(CLIMB_SHARE * agility_of(uav).slope for uav in self.wings)])
