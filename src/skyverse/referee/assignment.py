"""Judges who is sent where, and which results and trajectories a mission has."""

from skyverse.model.mission import Mission
from skyverse.model.result import Result
from skyverse.model.scenario import Scenario
from skyverse.model.short_lines import counted
from skyverse.model.trajectory import Trajectory
from skyverse.model.verdict import Fault, Violation
from skyverse.referee.alteration import alteration
from skyverse.referee.untrusted import target_index


def judge_assignment(scenario: Scenario, mission: Mission) -> list[Violation]:
    """Return what is wrong with who is sent where, and with which results and trajectories there are."""
    found = []
    count = len(scenario.uavs)
    fleet = counted(count, "UAV")
    if mission.scenario != scenario:
        found.append(Violation(Fault.SCENARIO, (), alteration(scenario, mission.scenario)))
    columns = {noun: getattr(mission, noun) for noun in ("assignment", "results", "trajectories")}
    for noun, values in columns.items():
        if len(values) != count:
            message = (
                f"The mission's {noun} has {counted(len(values), 'entry', 'entries')}, but the scenario has {fleet}."
            )
            found.append(Violation(Fault.ASSIGNMENT, (), message))
    takers: dict[int, int] = {}
    for uav in range(min(count, *(len(values) for values in columns.values()))):
        name = scenario.uavs[uav].name
        given, result, trajectory = mission.assignment[uav], mission.results[uav], mission.trajectories[uav]
        target = target_index(scenario, given)
        complaints = []
        if given is not None and target is None:
            complaints.append(f"is sent to target {given!r}, but targets are numbered 0 to {len(scenario.targets) - 1}")
        if target is not None and target in takers:
            other = scenario.uavs[takers[target]].name
            complaints.append(f"is sent to {scenario.targets[target].name}, which {other} already has")
        if target is not None:
            takers.setdefault(target, uav)
        for value, kind in ((result, Result), (trajectory, Trajectory)):
            if value is not None and not isinstance(value, kind):
                complaints.append(f"has a {type(value).__name__} in place of a {kind.__name__.lower()}")
        if given is not None and result is None:
            complaints.append("has a target but no result")
        for value, noun in ((result, "result"), (trajectory, "trajectory")):
            if given is None and value is not None:
                complaints.append(f"has a {noun} but no target")
        found += [Violation(Fault.ASSIGNMENT, (uav,), f"{name} {complaint}.") for complaint in complaints]
    wanted = min(count, len(scenario.targets))
    if len(takers) < wanted and not found:
        targets = len(scenario.targets)
        message = f"{len(takers)} of {fleet} have a target, but with {counted(targets, 'target')} {wanted} must."
        found.append(Violation(Fault.ASSIGNMENT, (), message))
    return found
