"""The record of a mission that was flown many times in simulation: frozen data with read-only arrays."""

from dataclasses import dataclass

import numpy as np

from skyverse.model.arrays import ArrayRecord, FloatArray, IntArray
from skyverse.model.conditions import Conditions
from skyverse.model.flight_record import Simulated
from skyverse.model.mission import Mission
from skyverse.model.short_lines import as_lines, counted
from skyverse.model.verdict import Violation
from skyverse.model.what_is_proven import not_judged_as_flown


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
