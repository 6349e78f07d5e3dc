"""Says what is in the way where a UAV has no way home: a solid thing, a rule such as a ceiling, or the bounds."""

from dataclasses import dataclass
from typing import Literal

import numpy as np

from skyverse._typing import Floats
from skyverse.exports.flown_legs import Parts
from skyverse.exports.global_positions import origin_of
from skyverse.exports.return_lines import ReturnLines, ReturnSpace
from skyverse.exports.way_home import WayHome
from skyverse.model.geodesy import to_wgs84
from skyverse.model.scenario import Scenario
from skyverse.model.uav import TrackingError
from skyverse.referee.incursion import obstacle_text

ASKED_PARTS = 9
"""How many parts of a time without a way home are asked what is in the way; the middle one of those is told."""
CUTS, ROUNDS = 32, 4
"""A line is cut into so many pieces, and the first that is not safe again, to find the place: to 1 mm in 1 km."""
TOUCH = 1e-3
"""Metres by which shapes are widened to find the one that a place touches."""

Kind = Literal["solid", "rule", "bounds"]


@dataclass(frozen=True, eq=False)
class Obstruction:
    """What is in the way of a return.

    Attributes
    ----------
    kind
        ``"solid"``: ground or an obstacle; ``"rule"``: the ceiling above ground, or airspace such as a no-fly zone, and
        nothing solid; ``"bounds"``: the end of the space that is known, and nothing known inside of it.
    what
        What it is, in words.
    where
        The part of the return: ``"climb"``, ``"straight way home"`` or ``"descent"``.
    position
        (3,) metres: where the UAV comes too near to it.
    altitude
        The return altitude, metres above home.
    obstacle
        The number of the obstacle, if it is one.
    """

    kind: Kind
    what: str
    where: str
    position: Floats
    altitude: float
    obstacle: int | None = None

    def sentence(self, scenario: Scenario) -> str:
        """Return the end of a sentence on where the return meets what."""
        latitude, longitude, sea = to_wgs84(origin_of(scenario), self.position[None])[0].tolist()
        met = {
            "solid": f"comes too near to {self.what}, which is solid,",
            "rule": f"breaks a rule and meets nothing solid: it enters {self.what}",
            "bounds": f"leaves {self.what}, beyond which nothing is known,",
        }
        return (
            f"the {self.where} {met[self.kind]} at {latitude:.5f}, {longitude:.5f}, {sea:z.0f} m above mean sea level"
        )


def obstruction(space: ReturnSpace, way: WayHome, lost: Parts) -> Obstruction | None:
    """Return what is in the way from parts of a flight: what is solid if anything is, from the middle of those parts.

    ``None`` if nothing is in the way from the parts that are asked.
    """
    asked = np.unique(np.linspace(0, len(lost.leg) - 1, ASKED_PARTS).round().astype(int))
    lines, part = way.lines(lost.of(asked))
    safe = space.free(lines, way.error)
    for asked_of, blocked in ((space.solids, ~space.solids.free(lines, way.error)), (space, ~safe)):
        parts = np.unique(part[blocked])
        if len(parts):
            first = int(np.flatnonzero(blocked & (part == parts[len(parts) // 2]))[0])
            return _met(asked_of, lines.of(np.array([first])), way)
    return None


def _met(space: ReturnSpace, line: ReturnLines, way: WayHome) -> Obstruction:
    """Return what one line, of which it is known that it is not safe, meets first."""
    down = float(line.ends[0, 2] - line.starts[0, 2])
    level = float(np.abs(line.ends - line.starts)[0, :2].max())
    where = "straight way home" if level > 0 else "descent" if down < 0 else "climb"
    if not space.in_bounds(line, way.error)[0]:
        bounds = space.scenario.bounds
        ends = np.concatenate([line.starts, line.ends])
        beyond = np.maximum(np.array(bounds.min) - ends, ends - np.array(bounds.max)).max(axis=1)
        return Obstruction("bounds", "the bounds", where, ends[int(np.argmax(beyond))], way.altitude)
    piece = _first_unsafe(space, line, way.error)
    position = ((piece.starts + piece.ends) / 2)[0]
    number = space.blocker(piece, way.error, TOUCH)
    solid: Kind = "solid" if space.only_solids else "rule"
    if number is not None:
        return Obstruction(solid, obstacle_text(way.scenario, number), where, position, way.altitude, number)
    if space.scenario.terrain is None:
        what = "a gap between obstacles that is too narrow"
    elif space.only_solids:
        what = "the ground"
    else:
        what = f"the air above the ceiling of {way.scenario.max_height:g} m above ground"
    return Obstruction(solid, what, where, position, way.altitude)


def _first_unsafe(space: ReturnSpace, line: ReturnLines, error: TrackingError) -> ReturnLines:
    """Return the first short piece of a line that is not safe, or the line itself if only the whole is not."""
    for _ in range(ROUNDS):
        shares = np.linspace(0.0, 1.0, CUTS + 1)[:, None]
        places = line.starts + shares * (line.ends - line.starts)
        pieces = line.of(np.zeros(CUTS, dtype=np.intp))._replace(starts=places[:-1], ends=places[1:])
        unsafe = np.flatnonzero(~space.free(pieces, error))
        if not len(unsafe):
            break
        line = pieces.of(unsafe[:1])
    return line
