"""The fleet's answer: who goes where, by which path and trajectory, and what the referee says of it."""

import math
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Literal, Protocol, TypeVar

import numpy as np

from skyverse.errors import InputError, did_you_mean, shown
from skyverse.model.arrays import ArrayRecord
from skyverse.model.coverage import Coverage, CoverageGap
from skyverse.model.quantities import Flag, Real, Whole
from skyverse.model.result import Provenance, Result
from skyverse.model.scenario import Scenario, Target
from skyverse.model.short_lines import SMALLEST_GAP, as_lines, counted, told_gap, told_metres, told_seconds
from skyverse.model.sortie import Sortie, Unvisited, Visit
from skyverse.model.trajectory import Trajectory
from skyverse.model.uav import UAV
from skyverse.model.verdict import Action, Certificate, Deconfliction, Violation

Part = TypeVar("Part")


@dataclass(frozen=True)
class FlightSummary:
    """What one UAV flies, beside the price of its path.

    Attributes
    ----------
    length
        Metres that are flown.
    time
        Seconds from departure to arrival.
    energy
        Joules that it takes by `UAV.power_model`; ``None`` where its power is not known.
    deviation
        Metres: no place that is flown is farther than this from the path that was priced, the result's.
    energy_bound
        Joules that it takes by the same model in gusts that are at their worst all the time, with take-off from the
        ground and landing.
    left
        Share of the battery that is then left at landing, of the share that is trusted, after the sortie that takes
        most: not below `UAV.reserve` if the battery suffices. ``None`` without a battery.
    """

    length: Real
    time: Real
    energy: Real | None
    deviation: Real
    energy_bound: Real | None = None
    left: Real | None = None


@dataclass(frozen=True, eq=False)
class Mission(ArrayRecord):
    """The fleet's answer. It embeds its scenario, so that one file is enough for everything that follows.

    Attributes
    ----------
    assignment
        The index of each UAV's target, of a tour that of its last one; ``None`` for a UAV without a target.
    results, trajectories
        One entry for each UAV, in the scenario's order; ``None`` where there is none. Those of a tour lead through all
        of its targets, and home wherever it goes there.
    sorties
        Of tours: the flights of each UAV, in the scenario's order; empty where each UAV flies to one target and stays
        there. See `sorties_of`.
    unvisited
        Of tours: the targets that no UAV visits, each with why.
    unseen
        Of surveys: the parts that no UAV flies to see, each with why.
    violations
        What the referee found wrong when the mission was planned; empty if nothing. `check` judges anew.
    interrupted
        Whether the run was interrupted; what was found until then is kept, and not judged.
    certificates
        What the referee proved of each UAV's trajectory, in the scenario's order; empty if it was not asked, as of a
        mission that was read from a file: no file holds certificates, and `certify` makes them anew.
    apart
        What the referee proved of the fleet's separation; ``None`` if it was not asked.
    coverage
        What it proved of the photos of each survey; empty if it was not asked. None of these three counts when missions
        are compared.
    deconfliction
        How conflicts between trajectories were resolved; ``None`` if that was not tried.
    flights
        What each UAV flies beside the price of its path, in the scenario's order, ``None`` for a UAV that does not fly;
        empty where nothing is stated.
    source
        What the command line read the scenario from: the name of a built-in one, or a file, as a path from the folder
        of the mission's file; ``None`` for a mission made otherwise.
    """

    scenario: Scenario
    assignment: tuple[Whole | None, ...]
    results: tuple[Result | None, ...]
    trajectories: tuple[Trajectory | None, ...]
    violations: tuple[Violation, ...]
    provenance: Provenance
    interrupted: Flag = False
    certificates: tuple[Certificate | None, ...] = field(default=(), compare=False)
    apart: Certificate | None = field(default=None, compare=False)
    coverage: tuple[Coverage, ...] = field(default=(), compare=False)
    deconfliction: Deconfliction | None = None
    flights: tuple[FlightSummary | None, ...] = ()
    sorties: tuple[tuple[Sortie, ...], ...] = ()
    unvisited: tuple[Unvisited, ...] = ()
    unseen: tuple[CoverageGap, ...] = ()
    source: str | None = None
    format: Literal["skyverse/mission/2"] = "skyverse/mission/2"

    def __repr__(self) -> str:
        flying = sum(trajectory is not None for trajectory in self.trajectories)
        fleet = len(self.scenario.uavs)
        who = counted(fleet, "UAV") if flying == fleet else f"{flying:,} of {counted(fleet, 'UAV')}"
        who = f"{who} {'flies' if flying == 1 else 'fly'}" if flying else "nobody flies"
        judged = f", {self._judged}" if flying or self.violations else ""
        length = sum(flight.length for flight in self.flights if flight is not None)
        flown = f"{told_metres(length)} flown, " if length else ""
        return as_lines(
            f"Mission {self.scenario.name!r}: {who}{judged}",
            "" if self.complete else "not complete: " + self.missing,
            f"total cost {self.total_cost_sentence}",
            self._visits if self.sorties else "",
            *(f"coverage of {self.scenario.surveys[one.survey].name}: {one.verdict.value}" for one in self.coverage),
            f"{flown}last arrival after {told_seconds(self.makespan)}" if flying else "",
            f"by {self.provenance.planner_and_seed}",
        )

    def result(self, uav: int | str) -> Result:
        """Return the result of a UAV, by its index or name.

        Raises
        ------
        InputError
            If there is no such UAV, or it has none.
        """
        return self._of(uav, self.results, "result")

    def trajectory(self, uav: int | str) -> Trajectory:
        """Return the trajectory of a UAV, by its index or name.

        Raises
        ------
        InputError
            If there is no such UAV, or it does not fly.
        """
        return self._of(uav, self.trajectories, "trajectory")

    def certificate(self, uav: int | str | None = None) -> Certificate:
        """Return what the referee proved: of a UAV's trajectory, by its index or name, or of the fleet's separation.

        Raises
        ------
        InputError
            If there is no such UAV, or it does not fly, or the referee was not asked, as of a mission that was read.
        """
        if uav is None:
            if self.apart is None:
                raise InputError("the referee was not asked of this mission's separation; certify(...) asks it")
            return self.apart
        return self._of(uav, self.certificates, "certificate")

    def _of(self, uav: int | str, column: tuple[Part | None, ...], noun: str) -> Part:
        index = index_of(self.scenario.uavs, uav, "uav")
        found = column[index] if index < len(column) else None
        if found is None:
            raise InputError(f"{self.scenario.uavs[index].name} has no {noun} in this mission", field="uav")
        return found

    @property
    def actions(self) -> tuple[Action, ...]:
        """What was changed to keep the UAVs apart, in order."""
        return () if self.deconfliction is None else self.deconfliction.actions

    @property
    def costs(self) -> dict[str, float]:
        """The sums of the results' costs by unit, ``"nodes"`` and ``"metres"``; those in different units do not mix.

        Where the objective counts nodes, paths that leave the lattice have none, and their costs are in metres. A
        result without a path makes every sum infinite.
        """
        found = [result for result in self.results if result is not None]
        lost = sum(result.cost for result in found if not len(result.path))
        sums: dict[str, float] = {}
        for result in found:
            if len(result.path):
                unit = "metres" if result.any_angle else self.scenario.objective.unit
                sums[unit] = sums.get(unit, lost) + result.cost
        return sums or ({self.scenario.objective.unit: lost} if found else {})

    @property
    def cost(self) -> float:
        """The sum of the results' costs; NaN where they are in two units, which `costs` tells apart."""
        sums = list(self.costs.values())
        return sums[0] if len(sums) == 1 else math.nan if sums else 0.0

    @property
    def gap(self) -> float | None:
        """By which share the sum of all costs exceeds that of their bounds; ``None`` where that is not known."""
        results = [result for result in self.results if result is not None]
        bounds = [result.bound for result in results if result.bound is not None and result.status.reached]
        if len(self.costs) != 1 or len(bounds) < len(results) or sum(bounds) <= 0:
            return None
        return self.cost / sum(bounds) - 1

    @property
    def makespan(self) -> float:
        """Seconds until the last UAV has arrived."""
        return max((trajectory.end for trajectory in self.trajectories if trajectory is not None), default=0.0)

    @property
    def total_time(self) -> float:
        """The sum of the UAVs' arrival times, seconds into the mission."""
        return sum((trajectory.end for trajectory in self.trajectories if trajectory is not None), 0.0)

    @property
    def complete(self) -> bool:
        """Whether as many UAVs as possible have a target, each with a path and a trajectory; of tours, all targets."""
        pairs = min(len(self.scenario.uavs), len(self.scenario.targets))
        assigned = sum(target is not None for target in self.assignment)
        return (
            not self.interrupted
            and not self.unvisited
            and (len(self.visited) == len(self.scenario.targets) if self.sorties else assigned == pairs)
            and all(
                target is None or (result is not None and result.status.reached and trajectory is not None)
                for target, result, trajectory in zip(self.assignment, self.results, self.trajectories, strict=True)
            )
        )

    @property
    def seen(self) -> bool:
        """Whether the photos are proven to show all that the surveys ask for."""
        return all(one.verdict.value == "proven" for one in self.coverage)

    @property
    def visited(self) -> frozenset[int]:
        """The indices of the targets at which UAVs arrive."""
        own = (self.sorties_of(uav) for uav in range(len(self.scenario.uavs)))
        return frozenset(visit.target for sorties in own for sortie in sorties for visit in sortie.visits)

    @property
    def spare_targets(self) -> tuple[int, ...]:
        """The indices of the targets to which no UAV is sent."""
        sent = self.visited | {target for target in self.assignment if target is not None}
        return tuple(k for k in range(len(self.scenario.targets)) if k not in sent)

    @property
    def total_cost_sentence(self) -> str:
        """The sums of the costs by unit, and how far they are above the best possible, where that is known."""
        told = " and ".join(f"{value:,.6g} {unit}" for unit, value in self.costs.items()) or "none"
        results = [result for result in self.results if result is not None]
        gap = self.gap
        if gap is None:
            return told
        lattice = "" if any(result.any_angle for result in results) else " on the lattice"
        if abs(gap) <= SMALLEST_GAP:
            return f"{told}, no paths{lattice} cost less"
        if all(result.straight_bound for result in results):
            return f"{told}, at most {told_gap(gap)} above the straight lines, which no paths beat"
        return f"{told}, at most {told_gap(gap)} above the best possible{lattice}"

    @property
    def _judged(self) -> str:
        """What the referee says of the mission, in a few words."""
        if self.violations:
            return f"{counted(len(self.violations), 'thing')} found wrong"
        if self.apart is None:
            return "not judged"
        certificates = [*self.certificates, self.apart]
        proven = all(one is None or one.verdict.value == "proven" for one in certificates)
        return "proven safe at every instant" if proven else "nothing found wrong"

    @property
    def _visits(self) -> str:
        """How many targets are visited and strips flown, in how many flights."""
        many = counted(sum(map(len, self.sorties)), "sortie")
        strips = sum(len(one.strips) for sorties in self.sorties for one in sorties)
        flown = [f"{counted(strips, 'strip')} flown"] if strips else []
        visited = f"{len(self.visited):,} of {counted(len(self.scenario.targets), 'target')} visited"
        return f"{' and '.join([visited, *flown] if self.scenario.targets or not flown else flown)} in {many}"

    @property
    def missing(self) -> str:
        """What a mission lacks that is not complete."""
        if self.interrupted:
            return "the run was interrupted"
        without = sum(
            target is not None and trajectory is None
            for target, trajectory in zip(self.assignment, self.trajectories, strict=True)
        )
        missed = [f"{counted(len(self.unvisited), 'target')} that nobody visits"] if self.unvisited else []
        return " and ".join(missed or [f"{counted(without, 'UAV')} with a target but no way to it"])

    def sorties_of(self, uav: int) -> tuple[Sortie, ...]:
        """Return the flights of a UAV, by its index: as stated, or the one to its target; none without a trajectory."""
        if self.sorties:
            return self.sorties[uav] if 0 <= uav < len(self.sorties) else ()
        target, trajectory = _entry(self.assignment, uav), _entry(self.trajectories, uav)
        if target is None or trajectory is None:
            return ()
        arrival = Visit(target, trajectory.end, trajectory.end)
        return (Sortie(trajectory.start, trajectory.end, (arrival,)),)


Thing = TypeVar("Thing")


@dataclass(frozen=True, eq=False)
class PlannedFlight:
    """One UAV and what was planned for it; ``None`` where there is no such thing."""

    uav: UAV
    target: Target | None = None
    result: Result | None = None
    trajectory: Trajectory | None = None
    summary: FlightSummary | None = None
    sorties: tuple[Sortie, ...] = ()

    @property
    def status(self) -> str:
        """How the search for its path ended, in words."""
        if self.result is not None:
            return self.result.status.value
        return "stays at its start" if self.target is None else "not planned"


def planned_flights(mission: Mission) -> tuple[PlannedFlight, ...]:
    """Return what a mission holds of each UAV, in the scenario's order.

    Entries that are missing, that name no target, or that are trajectories without sound numbers count as ``None``.
    """
    flights = []
    for k, uav in enumerate(mission.scenario.uavs):
        wanted, trajectory = _entry(mission.assignment, k), _entry(mission.trajectories, k)
        flights.append(
            PlannedFlight(
                uav=uav,
                target=None if wanted is None else _entry(mission.scenario.targets, wanted),
                result=_entry(mission.results, k),
                trajectory=trajectory if trajectory is not None and _sound(trajectory) else None,
                summary=_entry(mission.flights, k),
                sorties=mission.sorties_of(k),
            )
        )
    return tuple(flights)


def _entry(things: Sequence[Thing | None], number: int) -> Thing | None:
    return things[number] if 0 <= number < len(things) else None


def _sound(trajectory: Trajectory) -> bool:
    """Return whether a trajectory can be evaluated; one that was read from a file may have a wrong shape."""
    knots, coefficients = trajectory.knots, trajectory.coefficients
    if (
        coefficients.ndim != 3
        or coefficients.shape[2] != 3
        or coefficients.shape[1] < 1
        or knots.shape != (len(coefficients) + 1,)
    ):
        return False
    rising = len(knots) > 1 and bool(np.all(np.diff(knots) > 0))
    return rising and bool(np.isfinite(knots).all() and np.isfinite(coefficients).all())


class Named(Protocol):
    """What has a name."""

    @property
    def name(self) -> str:
        """Its name."""


def index_of(things: Sequence[Named], which: int | str, field: str) -> int:
    """Return the index of a thing, which is given by its index or its name.

    Raises
    ------
    InputError
        If there is none, named by `field`.
    """
    names = [thing.name for thing in things]
    if isinstance(which, str) and which in names:
        return names.index(which)
    if isinstance(which, int | np.integer) and not isinstance(which, bool) and 0 <= which < len(things):
        return int(which)
    near = did_you_mean(which, names) if isinstance(which, str) else ""
    known = f"an index below {len(things)}, or a name," if things else "none, since there are none,"
    raise InputError(f"expected {known} found {shown(which)}{near}", field=field)
