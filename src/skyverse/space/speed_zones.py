"""Zones with a speed limit, compiled: where a UAV that may stray from its nominal position can be inside one."""

from typing import NamedTuple

from skyverse._typing import Floats
from skyverse.model.scenario import Scenario
from skyverse.model.uav import TrackingError
from skyverse.space import solids
from skyverse.space.solids import Solids, make_solids
from skyverse.space.voxels import parts_of

BISECTIONS = 40
"""Halvings by which the place is found at which a leg enters or leaves a zone."""


class SpeedZone(NamedTuple):
    """A zone in which no UAV may fly faster than its limit.

    Attributes
    ----------
    number
        Its number among the scenario's zones.
    max_speed
        m/s.
    solids
        What it consists of, made higher for the vertical tracking error.
    growth
        Metres by which the horizontal tracking error grows it.
    """

    number: int
    max_speed: float
    solids: Solids
    growth: float

    def holds(self, p: Floats) -> bool:
        """Tell whether a UAV at a nominal position (3,) may be inside."""
        return bool(solids.containing(self.solids, self.growth, p[0], p[1], p[2]) >= 0)

    def reaches(self, low: Floats, high: Floats) -> bool:
        """Tell whether the zone reaches into the box between two corners, (3,) each."""
        return bool(solids.reaching(self.solids, self.growth, low, high) >= 0)

    def crossed(self, a: Floats, b: Floats, margin: float = 0.0) -> bool:
        """Tell whether a segment comes nearer to the zone than `margin` metres, or into it."""
        return bool(solids.crossed(self.solids, self.growth + margin, a, b) >= 0)

    def stretch(self, a: Floats, b: Floats, margin: float) -> tuple[float, float] | None:
        """Return the shares of a segment between which it is inside the zone or within `margin` of it, or ``None``."""
        if not self.crossed(a, b, margin):
            return None
        ends = []
        for begin, end in ((a, b), (b, a)):
            clear, met = 0.0, 1.0
            for _ in range(BISECTIONS):
                middle = 0.5 * (clear + met)
                if self.crossed(begin, begin + middle * (end - begin), margin):
                    met = middle
                else:
                    clear = middle
            ends.append(clear)
        return ends[0], 1.0 - ends[1]


def make_speed_zones(scenario: Scenario, error: TrackingError) -> tuple[SpeedZone, ...]:
    """Return the zones of a scenario that have a speed limit at all times, for UAVs with a tracking error."""
    made = []
    for number, zone in enumerate(scenario.zones):
        if zone.max_speed is not None and zone.active is None:
            parts = make_solids(parts_of(zone), error)[0]
            made.append(SpeedZone(number, zone.max_speed, parts, error.horizontal))
    return tuple(made)
