"""The fleet's answer: who goes where, by which path and trajectory, and what the referee says of it."""

from dataclasses import dataclass, field

from skyverse.model.arrays import ArrayRecord
from skyverse.model.result import Provenance, Result
from skyverse.model.scenario import Scenario
from skyverse.model.trajectory import Trajectory
from skyverse.model.verdict import Certificate, Deconfliction, Violation


@dataclass(frozen=True, eq=False)
class Mission(ArrayRecord):
    """The fleet's answer. It embeds its scenario, so that one file serves every later verb.

    Attributes
    ----------
    assignment
        For each UAV the index of its target, or ``None``.
    results, trajectories
        In the scenario's order of UAVs; ``None`` where there is none.
    violations
        The referee's verdict; empty when nothing was found wrong.
    interrupted
        Whether the run was cut short; what was found until then is kept.
    certificates
        What the referee says of each UAV's trajectory, in the scenario's order; empty when it was not asked.
    apart
        What it says of the fleet's separation; ``None`` when it was not asked.
    deconfliction
        How conflicts between trajectories were resolved; ``None`` when that was not tried.
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
    format: str = field(default="skyverse/mission/1")

    @property
    def cost(self) -> float:
        """The sum of the results' costs, in the objective's unit.

        A detour that keeps UAVs apart is priced in metres: where the others' paths count nodes, the sum means nothing.
        """
        return sum(result.cost for result in self.results if result is not None)

    @property
    def makespan(self) -> float:
        """Seconds until the last UAV has arrived."""
        return max((trajectory.end for trajectory in self.trajectories if trajectory is not None), default=0.0)

    @property
    def total_time(self) -> float:
        """The sum of the UAVs' arrival times, seconds into the mission."""
        return sum(trajectory.end for trajectory in self.trajectories if trajectory is not None)

    @property
    def complete(self) -> bool:
        """Whether as many UAVs as can have a target, and each has a path to it and a trajectory along it."""
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
