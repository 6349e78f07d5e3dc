"""What may be wrong with a mission that people have: records without sentences, which `report` makes of them."""

from dataclasses import dataclass
from enum import StrEnum

from skyverse.exports.way_home import UNPROVEN, WAYS
from skyverse.model.shapes import FENCE, Shape


class Subject(StrEnum):
    """What a finding is about: the rows of the table."""

    ORDERS = "orders"
    LEGS = "legs"
    CORNERS = "corners"
    TAKEOFF = "take-off"
    END = "end"
    WAY_HOME = "way home"
    HOME = "home"
    LIMITS = "limits"
    APART = "separation"


class FindingKind(StrEnum):
    """What is found."""

    GROUND = "ground"
    CEILING = "ceiling"
    BOUNDS = "bounds"
    OBSTACLE = "obstacle"
    ZONE = "zone"
    FENCE = "fence"
    UNDECIDED = "undecided"
    CURVED = "curved"
    LANDING = "landing"
    CLIMB, LEVEL_WAY, DESCENT, NEAR_HOME, UNPROVEN = *WAYS, UNPROVEN
    """Of a return, what is not clear."""
    NO_WAY_BACK = "no way back along the mission"
    RALLY = "rally points"
    HOME_ALTITUDE = "altitude of home"
    NOT_FOLLOWED = "order not followed"
    NO_TERRAIN_FOLLOWING = "heights above ground"
    NO_CIRCLES = "circles of multirotors"
    SPEED = "speed"
    CLOSE = "too close"
    TURNS = "turns of aeroplanes"
    RETURN = "returns of aeroplanes"
    NOT_AEROPLANE = "not an aeroplane"
    COUNT = "count of items"
    LENGTH = "length of a leg"
    BATTERY = "battery"


def kind_of(shape: Shape) -> FindingKind:
    """Return what is found where an obstacle of a scenario is met."""
    return FindingKind.FENCE if shape.kind == FENCE else FindingKind.OBSTACLE if shape.solid else FindingKind.ZONE


_Kind = FindingKind
_HEEDED = (_Kind.NEAR_HOME, _Kind.TURNS, _Kind.RETURN, _Kind.COUNT, _Kind.LENGTH)
"""What refutes no mission."""
_MET = (_Kind.GROUND, _Kind.CEILING, _Kind.BOUNDS, _Kind.OBSTACLE, _Kind.ZONE, _Kind.FENCE)
"""What a leg, a corner or a take-off comes too near to."""


@dataclass(frozen=True)
class MissionFinding:
    """One thing that is wrong with a mission, or must be heeded.

    Attributes
    ----------
    subject
        What it is about.
    kind
        What is found.
    items
        The numbers of the orders concerned, as ground stations show them.
    place
        Latitude, longitude and metres above mean sea level, where it has a place.
    name
        The kind and name of an obstacle, the name of another vehicle, of orders or of
        what has a limit, or why it cannot land or
        go back.
    found, limit
        What was found and what is allowed: metres from the ground, the ceiling, the bounds or an obstacle that are left
        by all that the vehicle may stray, negative beyond it, and the clearance that is to be left; the altitude of
        home in the file and the ground there; a speed, m/s; a count; metres of a leg; joules.
    clear_at
        Metres above mean sea level at which the vehicle would be clear there; ``None`` where no height clears it.
    times
        Seconds into the mission from which and until which it is so, of a return and of vehicles that come too close.
    part
        Which leg or corner of the flight it is, as `FlownMission.visits` count them.
    corner
        Whether it is a corner.
    """

    subject: Subject
    kind: FindingKind
    items: tuple[int, ...] = ()
    place: tuple[float, float, float] | None = None
    name: str = ""
    found: float | None = None
    limit: float | None = None
    clear_at: float | None = None
    times: tuple[float, float] | None = None
    part: int | None = None
    corner: bool = False

    @property
    def wrong(self) -> bool:
        """Whether it refutes the mission; otherwise it is something to heed."""
        return self.kind not in _HEEDED

    @property
    def what(self) -> str:
        """What is met or found: the name where it has one, or else the kind."""
        return self.name or self.kind.value

    @property
    def deep(self) -> float | None:
        """Metres by which a leg, a corner or a take-off is too near to what it meets."""
        if self.kind not in _MET or self.found is None or self.limit is None:
            return None
        return self.limit - self.found
