"""What came of a flight in a simulator: plain frozen data; arrays are read-only."""

from dataclasses import dataclass, field

from skyverse.model.arrays import ArrayRecord, FloatArray, PointArray
from skyverse.model.mission import Mission
from skyverse.model.verdict import Violation


@dataclass(frozen=True, eq=False)
class Flown(ArrayRecord):
    """One UAV's flight.

    Attributes
    ----------
    uav
        Its index.
    times
        (m,) seconds into the mission, a hundredth apart, from its departure until a second after its arrival, or
        until it was lost.
    positions, velocities
        (m, 3) metres and m/s: as flown.
    commanded
        (m, 3) metres: where its trajectory is at those times.
    rms, largest
        The tracking error, metres: its root mean square, and the largest.
    clearance, clearance_time
        The smallest Euclidean distance to any obstacle as given, metres, and when; 0 or less is contact.
    above_ground
        The least height above the terrain, metres; ``None`` where there is no terrain.
    outside
        By how many metres it left the bounds; 0 inside.
    peak_thrust, mean_thrust
        The rotors' thrust as a share of their most.
    peak_tilt
        Degrees between thrust and the vertical.
    energy
        Joules: the mechanical power of the rotors, yaw moment times speed, summed over the flight.
    """

    uav: int
    times: FloatArray
    positions: PointArray
    velocities: PointArray
    commanded: PointArray
    rms: float
    largest: float
    clearance: float
    clearance_time: float
    outside: float
    peak_thrust: float
    mean_thrust: float
    peak_tilt: float
    energy: float
    above_ground: float | None = None


@dataclass(frozen=True)
class Passing:
    """Two UAVs when they were closest, as flown.

    Attributes
    ----------
    uavs
        Their indices.
    time
        Seconds into the mission.
    distance
        Metres then.
    nearness
        How close then, as a share of the separation: 1 is on the ellipsoid, 0 at one place.
    planned
        The smallest nearness of their trajectories at the same times.
    """

    uavs: tuple[int, int]
    time: float
    distance: float
    nearness: float
    planned: float


@dataclass(frozen=True, eq=False)
class Flight(ArrayRecord):
    """A mission flown in a simulator.

    Attributes
    ----------
    mission
        What was flown.
    vehicle, wind, noise, seed
        In what: the vehicle's name, the wind's velocity (m/s), the noise of position (m) and velocity (m/s).
    margin
        How far a UAV may stray, metres; see `fly`.
    flown
        In the scenario's order of UAVs; ``None`` where a UAV has no trajectory, or is an aeroplane.
    passings
        All pairs of UAVs that must keep a separation.
    violations
        What went wrong as flown; empty when nothing did.
    rounds
        What `fly_until_safe` did, a sentence a round.
    """

    mission: Mission
    vehicle: str
    wind: tuple[float, float, float]
    noise: float
    seed: int | None
    margin: float
    flown: tuple[Flown | None, ...]
    passings: tuple[Passing, ...]
    violations: tuple[Violation, ...]
    rounds: tuple[str, ...] = ()
    format: str = field(default="skyverse/flight/1")

    @property
    def safe(self) -> bool:
        """Whether nothing went wrong."""
        return not self.violations

    @property
    def sentence(self) -> str:
        """The verdict, and the thresholds that it used."""
        scenario = self.mission.scenario
        if self.safe:
            ground = scenario.ground_clearance - self.margin
            over = "" if scenario.terrain is None else f" and {ground:.3g} m above ground"
            return (
                f"Safe: {scenario.clearance - self.margin:.3g} m or more were left to every obstacle{over}, no UAV "
                f"strayed more than {self.margin:.3g} m out of bounds or off its target, nor two by more than that "
                "each into their separation."
            )
        things = "1 thing" if len(self.violations) == 1 else f"{len(self.violations)} things"
        return f"Not safe: {things} went wrong."

    @property
    def largest(self) -> float:
        """The largest tracking error of all UAVs, metres."""
        return max((flown.largest for flown in self.flown if flown is not None), default=0.0)
