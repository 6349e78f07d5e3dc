"""The fleet's answer: who goes where, by which path and trajectory, and what the referee says of it."""

from dataclasses import dataclass, field

from skyverse.model.arrays import ArrayRecord
from skyverse.model.formats import MISSION_2
from skyverse.model.result import Provenance, Result
from skyverse.model.scenario import Scenario
from skyverse.model.trajectory import Trajectory
from skyverse.model.verdict import Certificate, Deconfliction, Violation


@dataclass(frozen=True, eq=False)
class Mission(ArrayRecord):
    """The fleet's answer. It embeds its scenario, so that one file is enough for everything that follows.

    Attributes
    ----------
    assignment
        The index of each UAV's target, ``None`` for a UAV without a target.
    results, trajectories
        One entry for each UAV, in the scenario's order; ``None`` where there is none.
    violations
        What the referee found wrong; empty if nothing.
    interrupted
        Whether the run was interrupted; what was found until then is kept.
    certificates
        What the referee proved of each UAV's trajectory, in the scenario's order; empty if it was not asked.
    apart
        What the referee proved of the fleet's separation; ``None`` if it was not asked.
    deconfliction
        How conflicts between trajectories were resolved; ``None`` if that was not tried.
    """

    scenario: Scenario
    assignment: tuple[int | None, ...]
    results: tuple[Result | None, ...]
    trajectories: tuple[Trajectory | None, ...]
    violations: tuple[Violation, ...]
    provenance: Provenance
    interrupted: bool = False
    certificates: tuple[Certificate | None, ...] = ()
    apart: Certificate | None = None
    deconfliction: Deconfliction | None = None
    format: str = field(default=MISSION_2)

    @property
    def cost(self) -> float:
        """The sum of the results' costs, in the objective's unit.

        The cost of a detour around another UAV is in metres; the sum means nothing where other paths count nodes.
        """
        return sum(result.cost for result in self.results if result is not None)

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
        """Whether as many UAVs as possible have a target, and each of them a path to it and a trajectory."""
        pairs = min(len(self.scenario.uavs), len(self.scenario.targets))
        assigned = sum(target is not None for target in self.assignment)
        return (
            not self.interrupted
            and assigned == pairs
            and all(
                target is None or (result is not None and result.status.reached and trajectory is not None)
                for target, result, trajectory in zip(self.assignment, self.results, self.trajectories, strict=True)
            )
        )
