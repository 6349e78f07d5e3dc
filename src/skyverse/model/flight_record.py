"""The records of a mission that was flown in a simulator, once or many times: frozen data with read-only arrays."""

import math
from collections.abc import Collection
from dataclasses import dataclass, field

import numpy as np

from skyverse.model.arrays import ArrayRecord, FloatArray, IntArray, PointArray
from skyverse.model.conditions import DEFAULT_VEHICLE, Conditions, is_stand_in, simulated_vehicle_sentence
from skyverse.model.mission import Mission
from skyverse.model.quantities import Real, Whole
from skyverse.model.short_lines import as_lines, counted, told_metres, told_seconds
from skyverse.model.sortie import Visit
from skyverse.model.timed_shapes import not_judged_as_flown
from skyverse.model.uav import TrackingError
from skyverse.model.verdict import Violation


@dataclass(frozen=True, eq=False)
class Flown(ArrayRecord):
    """One UAV's flight.

    Attributes
    ----------
    uav
        The index of the UAV.
    times
        (m,) seconds into the mission, a hundredth of a second apart, from the departure until one second after the
        arrival, or until the UAV was lost.
    positions, velocities
        (m, 3) metres and m/s, as flown.
    commanded
        (m, 3) metres: where the trajectory is at those times.
    rms, largest
        The root mean square and the maximum of the tracking error, metres.
    clearance, clearance_time
        The smallest Euclidean distance to any obstacle as given, metres, and its time, seconds; 0 or less is contact.
    above_ground
        The smallest height above the terrain, metres; ``None`` where there is no terrain.
    outside
        How far the UAV left the bounds at most, metres; 0 if it stayed inside.
    peak_thrust, mean_thrust
        The largest and the mean thrust of the rotors, as a share of their maximum.
    peak_tilt
        The largest angle between the thrust and the vertical, degrees.
    energy
        Joules: the integral over the flight of the rotors' mechanical power, which is yaw moment times speed.
    """

    uav: Whole
    times: FloatArray
    positions: PointArray
    velocities: PointArray
    commanded: PointArray
    rms: Real
    largest: Real
    clearance: Real
    clearance_time: Real
    outside: Real
    peak_thrust: Real
    mean_thrust: Real
    peak_tilt: Real
    energy: Real
    above_ground: Real | None = None

    def __repr__(self) -> str:
        return (
            f"Flown: UAV number {self.uav} for {told_seconds(float(self.times[-1] - self.times[0]))}, tracking error "
            f"at most {told_metres(self.largest)}, {told_metres(self.clearance)} to the nearest obstacle"
        )


@dataclass(frozen=True)
class Nearest:
    """The least distance that something came to, as flown.

    Attributes
    ----------
    uavs
        The indices of the UAVs that came there: one, or two that came near to each other; none where nothing did.
    time
        Seconds into the mission.
    distance
        Metres then, from the middle of a UAV to what it came near to, or to the middle of another UAV; 0 or less is
        contact.
    mover
        The index of the mover that a UAV came near to; ``None`` if it was none.
    nearness, planned
        For two UAVs that must keep a separation: the distance as a share of it, 1 on its ellipsoid, and the smallest
        such share of their trajectories over the same times.
    """

    uavs: tuple[Whole, ...]
    time: Real
    distance: Real
    mover: Whole | None = None
    nearness: Real | None = None
    planned: Real | None = None


@dataclass(frozen=True)
class FlownVisit:
    """A visit of a tour as it was flown.

    Attributes
    ----------
    uav, target
        Their indices.
    arrival, departure
        Seconds into the mission between which the UAV was to be there, one instant where it was to stay no longer.
    farthest
        Metres that it was from the target then at most; infinite if it was lost before.
    kept
        Whether that is no more than the margin, or a centimetre.
    """

    uav: Whole
    target: Whole
    arrival: Real
    departure: Real
    farthest: Real
    kept: bool


class Simulated:
    """A mission that was simulated, once or many times, under some conditions."""

    mission: Mission
    conditions: Conditions
    violations: Collection[object]

    @property
    def vehicle(self) -> str:
        """The name of the vehicle that was simulated."""
        return self.conditions.vehicle or DEFAULT_VEHICLE

    @property
    def vehicle_sentence(self) -> str:
        """Which vehicle was simulated, and for which other one the mission was planned, if it was."""
        return simulated_vehicle_sentence(self.vehicle, self.mission.scenario.uavs)

    @property
    def stands_in(self) -> bool:
        """Whether another vehicle was simulated than the planned one, so that there is no verdict."""
        return is_stand_in(self.vehicle, self.mission.scenario.uavs)

    @property
    def safe(self) -> bool:
        """Whether nothing went wrong, with the vehicle that was planned."""
        return not self.violations and not self.stands_in


@dataclass(frozen=True, eq=False)
class Flight(Simulated, ArrayRecord):
    """A mission flown in a simulator.

    Attributes
    ----------
    mission
        The mission that was flown.
    conditions
        What flew, with the vehicle's name, and what disturbed it.
    seed
        That of all that was drawn at random; ``None`` where nothing was, or where the caller made the generator.
    margin
        How far a UAV may stray from where it should be, metres; see `fly`.
    flown
        One entry for each UAV, in the scenario's order; ``None`` where it has no trajectory, or is an aeroplane.
    passings
        All pairs of UAVs that must keep a separation.
    violations
        What went wrong in the flight; empty if nothing did.
    rounds
        What `fly_until_safe` did, one sentence for each round.
    refusal
        Why it gave the mission up, in one sentence; empty if it did not.
    """

    mission: Mission
    conditions: Conditions
    seed: Whole | None
    margin: Real
    flown: tuple[Flown | None, ...]
    passings: tuple[Nearest, ...]
    violations: tuple[Violation, ...]
    rounds: tuple[str, ...] = ()
    refusal: str = ""
    format: str = field(default="skyverse/flight/1")

    def __repr__(self) -> str:
        return as_lines(
            f"Flight of mission {self.mission.scenario.name!r}: {self.sentence}",
            self.vehicle_sentence,
            f"largest tracking error {told_metres(self.largest)}",
        )

    @property
    def sentence(self) -> str:
        """The verdict in one sentence, with the thresholds that it used."""
        if self.refusal:
            return self.refusal
        scenario = self.mission.scenario
        wrong = f"{counted(len(self.violations), 'thing') if self.violations else 'nothing'} went wrong"
        if self.stands_in:
            return f"No verdict: {self.vehicle} is not the vehicle that was planned; with it {wrong}."
        if self.safe:
            ground = scenario.ground_clearance - self.margin
            kept = [f"{scenario.clearance - self.margin:.3g} m to every obstacle"] if scenario.obstacles else []
            kept += [] if scenario.terrain is None else [f"{ground:.3g} m above ground"]
            were = "was" if len(kept) == 1 else "were"
            left = f"at least {' and '.join(kept)} {were} left, " if kept else ""
            return (
                f"Safe: {left}no UAV strayed more than {self.margin:.3g} m out of bounds or off its target, nor two by "
                f"more than that each into their separation.{not_judged_as_flown(scenario)}"
            )
        return f"Not safe: {wrong}."

    @property
    def visits(self) -> tuple[FlownVisit, ...]:
        """The visits of all tours as they were flown, in the order of UAVs and then of time; empty without tours."""
        return tuple(
            flown_visit(one, visit, self.mission.scenario.targets[visit.target].position, self.margin)
            for one in self.flown
            if one is not None and self.mission.sorties
            for sortie in self.mission.sorties[one.uav]
            for visit in sortie.visits
        )

    @property
    def held(self) -> bool | None:
        """Whether all UAVs stayed within their stated tracking errors; ``None`` where none is stated."""
        uavs = self.mission.scenario.uavs
        flown = [one for one in self.flown if one is not None and uavs[one.uav].tracking_error != TrackingError()]
        if not flown:
            return None
        tubes = [(uavs[one.uav].tracking_error, one.positions - one.commanded) for one in flown]
        return all(
            (np.hypot(off[:, 0], off[:, 1]) <= tube.horizontal).all() and (np.abs(off[:, 2]) <= tube.vertical).all()
            for tube, off in tubes
        )

    @property
    def tube_sentence(self) -> str:
        """Whether the stated tracking errors held, in one sentence."""
        if self.held is None:
            return "No tracking error is stated, so there is none to hold."
        return f"The stated tracking error {'held' if self.held else 'was exceeded'}."

    @property
    def largest(self) -> float:
        """The largest tracking error of all UAVs, metres."""
        return max((flown.largest for flown in self.flown if flown is not None), default=0.0)


NEAR_ENOUGH = 0.01
"""Metres off its end, or off a target during a visit, that a UAV may be whatever the margin."""


def flown_visit(flown: Flown, visit: Visit, place: tuple[float, float, float], margin: float) -> FlownVisit:
    """Return a visit of a target at a place as it was flown, with the samples next to its beginning and its end."""
    first, last = np.searchsorted(flown.times, [visit.arrival, visit.departure])
    off = np.linalg.norm(flown.positions[max(first - 1, 0) : last + 1] - place, axis=1)
    farthest = float(off.max()) if last < len(flown.times) else math.inf
    kept = farthest <= max(margin, NEAR_ENOUGH)
    return FlownVisit(flown.uav, visit.target, visit.arrival, visit.departure, farthest, kept)


@dataclass(frozen=True)
class Distribution:
    """The distribution of one part of the tracking error over all samples, metres.

    Attributes
    ----------
    median, percentile_99
        What half of all samples, and 99 % of them, do not exceed; rounded up to millimetres.
    largest
        The largest of all.
    """

    median: float
    percentile_99: float
    largest: float


@dataclass(frozen=True)
class TrackingErrors:
    """How far UAVs were from where their trajectories are at the same time.

    Attributes
    ----------
    horizontal
        As seen from above.
    vertical
        In altitude, whether above or below.
    """

    horizontal: Distribution
    vertical: Distribution


@dataclass(frozen=True, eq=False)
class FlightRuns(Simulated, ArrayRecord):
    """A mission flown n times in simulation, each time with other disturbances.

    Attributes
    ----------
    mission
        The mission that was flown.
    conditions
        What flew, with the vehicle's name, and what disturbed the runs.
    radius
        How far the vehicle reaches from its centre, metres.
    seed
        That of all runs; ``None`` where nothing was drawn at random, or where the caller made the generator.
    seeds
        (n,) the seed of each run, with which `fly` flies it alone.
    errors
        The tracking errors of each UAV; ``None`` where it has no trajectory, or is an aeroplane.
    all_errors
        The tracking errors of all UAVs together.
    clearance
        (n,) metres: the smallest distance of any UAV's centre to an obstacle as given, or above the ground if that is
        less.
    separation, nearness
        (n,) the smallest distance between the centres of any two UAVs, metres, and as a share of their separation;
        infinite where there are no two that must keep one.
    outside
        (n,) metres by which a UAV left the bounds at most.
    largest
        (n, number of UAVs, 2) metres: the largest horizontal and vertical error of each UAV in each run.
    violations
        What went wrong first in each run in which anything did, by the number of the run, from 0.
    checks
        Whether the referee's code agrees with the least distances to obstacles, to the ground and to other UAVs.
    rounds
        What `fly_until_safe` did, one sentence for each round.
    refusal
        Why it gave the mission up, in one sentence; empty if it did not.
    """

    mission: Mission
    conditions: Conditions
    radius: float
    seed: int | None
    seeds: IntArray
    errors: tuple[TrackingErrors | None, ...]
    all_errors: TrackingErrors
    clearance: FloatArray
    separation: FloatArray
    nearness: FloatArray
    outside: FloatArray
    largest: FloatArray
    violations: dict[int, Violation]
    checks: tuple[str, ...] = ()
    rounds: tuple[str, ...] = ()
    refusal: str = ""

    def __repr__(self) -> str:
        return as_lines(
            f"{counted(self.runs, 'flight')} of mission {self.mission.scenario.name!r}",
            self.sentence,
            self.tube_sentence,
        )

    @property
    def runs(self) -> int:
        """How often the mission was flown."""
        return len(self.seeds)

    @property
    def held(self) -> tuple[bool, ...] | None:
        """For each run whether all UAVs stayed within their stated tracking errors; ``None`` where none is stated."""
        stated = [uav.tracking_error for uav in self.mission.scenario.uavs]
        tubes = np.array([(tube.horizontal, tube.vertical) for tube in stated])
        some = tubes.max(axis=1) > 0
        if not some.any():
            return None
        return tuple(bool(row) for row in (self.largest[:, some] <= tubes[some]).all(axis=(1, 2)))

    @property
    def tube_sentence(self) -> str:
        """Whether the stated tracking errors held, in one sentence."""
        held = self.held
        if held is None:
            return "No tracking error is stated, so there is none to hold."
        if all(held):
            return f"The stated tracking error held in all of {counted(self.runs, 'run')}."
        return f"The stated tracking error was exceeded in {held.count(False)} of {counted(self.runs, 'run')}."

    @property
    def sentence(self) -> str:
        """The verdict in one sentence."""
        if self.refusal:
            return self.refusal
        wrong = f"something went wrong in {len(self.violations)} of {counted(self.runs, 'run')}"
        if self.stands_in:
            return f"No verdict: {self.vehicle} is not the vehicle that was planned; with it {wrong}."
        if self.violations:
            return f"Not safe: {wrong}."
        bound = 1.0 - 0.05 ** (1.0 / self.runs)
        return (
            f"Safe: nothing was touched in any of {counted(self.runs, 'run')}, so that with 95 % confidence fewer than "
            f"{100 * bound:.2g} % of such flights touch anything.{not_judged_as_flown(self.mission.scenario)}"
        )
