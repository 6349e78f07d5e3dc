"""The waypoints of one UAV, as its autopilot is given them, and what is proven of them."""

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from skyverse._typing import Floats, Indices
from skyverse.exports.autopilots import AutopilotName, takeoff_cut
from skyverse.exports.leg_geometry import ground_allowance
from skyverse.exports.legs import Polyline
from skyverse.exports.photo_strips import (
    PhotoRun,
)
from skyverse.model.scenario import Scenario
from skyverse.model.short_lines import counted
from skyverse.numerics.tolerances import LEG_ALLOWANCE


class Takeoff(NamedTuple):
    """How a UAV comes to its first waypoint.

    Attributes
    ----------
    autopilot
        What flies it.
    climb
        Metres that it has to climb from its start, at least.
    risen
        Metres that its start is above where it stands.
    """

    autopilot: AutopilotName
    climb: float
    risen: float

    def early(self, climb: float, radius: float) -> float:
        """Return how many metres below its start a UAV may turn to its first leg, which begins `climb` above that."""
        return max(min(takeoff_cut(self.autopilot, radius) - climb, self.risen), 0.0)


@dataclass(frozen=True, eq=False)
class Route:
    """One UAV's waypoints.

    Attributes
    ----------
    uav
        The index of the UAV.
    points
        (n, 3) metres. The first is the start; with a takeoff the second lies vertically above it.
    times
        (n,) seconds into the mission at which the UAV arrives: those of the trajectory plus all stops before. The
        take-off ends when the trajectory begins.
    radii
        (n,) metres: the acceptance radius with which each point is proven; 0 where the UAV stops at every waypoint.
    takeoff
        The height of the vertical climb from the start, metres.
    lead
        (k, 3) metres: where the proven part of the climb to the first of the `waypoints` begins, if there is one.
    off
        The largest deviation of flown legs from the trajectory, metres; with altitudes above ground it includes the
        rise and fall of the ground.
    holds
        (n,) seconds that the UAV stops at each waypoint; above 0 where the corner must not be cut.
    deviations
        (m - 1,) metres: how far each flown leg between two of the `waypoints` may be off the straight line.
    lifts
        As those of its `LegChecker`.
    over_ground
        (m - 1,) metres that the UAV may be beside each leg along which its height above ground changes evenly; NaN for
        others, whose `deviations` say all.
    targets
        (n,) the index of the target that the UAV visits at each waypoint; -1 where it visits none.
    sortie, to_home
        As those of its `ExportedFlight`.
    runs
        The photos that it takes, whose waypoints are numbered as in `waypoints`.
    """

    uav: int
    points: Floats
    times: Floats
    radii: Floats
    takeoff: float
    lead: Floats
    off: float
    holds: Floats
    deviations: Floats
    lifts: tuple[tuple[Floats, Floats], ...]
    over_ground: Floats
    targets: Indices
    sortie: int = 0
    to_home: bool = False
    runs: tuple[PhotoRun, ...] = ()

    @property
    def radius(self) -> float:
        """The largest acceptance radius, metres."""
        return float(self.radii.max())

    @property
    def waypoint_radii(self) -> Floats:
        """The acceptance radii of the waypoints, (m,) metres."""
        return self.radii[1:] if self.takeoff else self.radii

    @property
    def waypoints(self) -> Floats:
        """(m, 3) metres: the points without the start where the UAV first climbs above it."""
        return self.points[1:] if self.takeoff else self.points

    @property
    def waypoint_times(self) -> Floats:
        """When the UAV arrives at the waypoints, (m,) seconds."""
        return self.times[1:] if self.takeoff else self.times

    @property
    def waypoint_holds(self) -> Floats:
        """How long the UAV stops at the waypoints, (m,) seconds."""
        return self.holds[1:] if self.takeoff else self.holds

    @property
    def waypoint_targets(self) -> Indices:
        """The targets that the UAV visits at the waypoints, (m,) indices; -1 where it visits none."""
        return self.targets[1:] if self.takeoff else self.targets

    def name(self, scenario: Scenario, word: str = " sortie ") -> str:
        """Return what the flight is called: by its UAV and, where that has several, a word and its sortie."""
        uav = scenario.uavs[self.uav].name
        return f"{uav}{word}{self.sortie}" if self.sortie else uav

    @property
    def polyline(self) -> Polyline:
        """What the referee has to prove of it."""
        points = np.concatenate([self.lead, self.waypoints])
        before = np.zeros(len(self.lead))
        return points, np.r_[before, self.waypoint_radii], np.r_[before, self.waypoint_holds]

    def sentence(self, scenario: Scenario, corners: str | None = None) -> str:
        """Return a sentence on what is proven; how corners are flown may be said in other words."""
        count = counted(len(self.points), "waypoint")
        waypoints = f"{count}, {corners or self.corners}, at most {self.off:.3g} m off the trajectory"
        return f"{self.name(scenario)}: {waypoints}; {self.proof(scenario)}"

    @property
    def corners(self) -> str:
        """How corners are flown, in words."""
        if self.radius and len(self.waypoints) <= 2:
            return "no corners"
        if not self.radius:
            return "stopping at each"
        photographed = [one.on for one in self.runs if one.on == one.off]
        stops = ((self.waypoint_holds > 0) | (self.waypoint_radii <= 0)) & (self.waypoint_targets < 0)
        held = int(stops[: len(stops) - 1].sum() - stops[photographed].sum())
        return f"corners cut within {self.radius:.3g} m" + (f" but at {held}, where it stops" if held else "")

    def proof(self, scenario: Scenario) -> str:
        """Return the end of a sentence on what is proven of its legs."""
        error = scenario.uavs[self.uav].tracking_error
        it = "with its tracking error it" if error.horizontal or error.vertical else "it"
        pads = ", but for what it stands on at its start and target," if self.lifts else ""
        without = "" if scenario.obstacles else "; the scenario has no obstacles"
        return f"straight legs proven: {it}{pads} {_what_is_kept(scenario)}{without}."


def stop_seconds(radius: float) -> float:
    """Return how long a UAV stops at a waypoint, seconds, so that it gets there from within an acceptance radius."""
    return 2.0 + radius


def _what_is_kept(scenario: Scenario) -> str:
    """Say what legs keep: the bounds, and the distances from obstacles and ground where there are any."""
    kept = []
    if scenario.obstacles:
        kept.append(f"{max(scenario.clearance - LEG_ALLOWANCE, 0):.4g} m from every obstacle")
    if scenario.terrain is not None:
        kept.append(f"{max(scenario.ground_clearance - ground_allowance(scenario), 0):.4g} m above ground")
    said = ["stays inside the bounds"]
    said += [f"keeps at least {' and '.join(kept)}"] if kept else []
    said += [] if scenario.max_height is None else [f"stays at most {scenario.max_height:.6g} m above ground"]
    return " and ".join([", ".join(said[:-1]), said[-1]] if len(said) > 1 else said)
