"""The referee: judges a mission by recomputing everything, sharing nothing with those who planned it.

It is slow, obvious NumPy. `boxes`, `rounds`, `prisms` and `ground` know what is unsafe, `clearance` asks them all;
`path` judges results, with `soft` for what they pay; `polynomial` bounds polynomials for certain; with it `flight`
judges trajectories, each by its `limits`, `separation` the fleet, and `certificate` says it.
"""

from collections.abc import Iterator

import numpy as np

from skyverse.model.mission import Mission
from skyverse.model.result import Result, Status
from skyverse.model.scenario import Scenario
from skyverse.model.trajectory import Trajectory
from skyverse.model.verdict import Certificate, Fault, Verdict, Violation
from skyverse.referee.certificate import Certificates, certify, entry, judge_flight, target_of
from skyverse.referee.clearance import shut_space
from skyverse.referee.path import judge_result

__all__ = ["Certificates", "certify", "check", "check_result", "judge"]


def check(scenario: Scenario, mission: Mission) -> list[Violation]:
    """Judge a mission against the scenario that it answers.

    Safe is what lies within the closed bounds and not inside an obstacle grown by the clearance on every side
    (the grown box is a box), nor nearer above ground than the terrain's clearance. Whatever is wrong by at most 1e-6 m
    (m/s, relative) is let pass.

    Parameters
    ----------
    scenario
        What was given; the scenario that the mission embeds must equal it.
    mission
        What is judged. However malformed it is, violations come back and nothing is raised.

    Returns
    -------
    list of Violation
        Empty when nothing is wrong and all trajectories, and their separation, are proven; see `certify`. A trajectory
        gets at most one of each kind, at its worst instant, and so does each pair of UAVs that comes too close.

    Notes
    -----
    *Claims*, which only a search of one's own could refute: that there is no path, that none is cheaper (the bound,
    and a status of optimal), that a start or target is unsafe or shut in; and the seconds and effort spent.

    *Exact*: assignment, statuses, costs, path segments, ends and continuity at the knots.

    *Proven* at every instant: clearance, bounds and limits of trajectories, and separations. What is neither proven nor
    refuted is a violation too, `Fault.UNDECIDED`. A mission's own certificates are not trusted: one that says
    proven where the referee does not is `Fault.STATUS`.
    """
    return judge(scenario, mission)[0]


def judge(scenario: Scenario, mission: Mission) -> tuple[list[Violation], Certificates]:
    """Return what `check` and `certify` do, for the price of one."""
    with np.errstate(all="ignore"):
        violations = _judge_assignment(scenario, mission)
        space = shut_space(scenario)
        flown = judge_flight(scenario, space, mission)
        for uav in range(len(scenario.uavs)):
            target = target_of(scenario, entry(mission.assignment, uav))
            result, trajectory = entry(mission.results, uav), entry(mission.trajectories, uav)
            if isinstance(result, Result):
                if result.status is Status.NOT_PLANNED and not mission.interrupted:
                    message = f"{scenario.uavs[uav].name} was not planned, but the mission was not interrupted."
                    violations.append(Violation(Fault.STATUS, (uav,), message))
                violations += judge_result(scenario, space, uav, target, result, isinstance(trajectory, Trajectory))
            violations += flown.trajectories[uav]
        violations += [*flown.apart, *_judge_claims(scenario, mission, flown.certificates)]
        return violations, flown.certificates


def _judge_claims(scenario: Scenario, mission: Mission, true: Certificates) -> Iterator[Violation]:
    """Yield what a mission says to be proven, and is not."""
    claims = mission.certificates if isinstance(mission.certificates, tuple | list) else ()
    said = [(f"{uav.name}'s trajectory", (k,), entry(claims, k)) for k, uav in enumerate(scenario.uavs)]
    known = [*true.trajectories, true.apart]
    for (noun, uavs, claim), sure in zip([*said, ("the fleet's separation", (), mission.apart)], known, strict=True):
        proven = sure is not None and sure.verdict is Verdict.PROVEN
        if isinstance(claim, Certificate) and claim.verdict is Verdict.PROVEN and not proven:
            verdict = "not there" if sure is None else f"{sure.verdict.value}"
            yield Violation(Fault.STATUS, uavs, f"The mission says that {noun} is proven, but it is {verdict}.")


def check_result(scenario: Scenario, uav: int, target: int, result: Result) -> list[Violation]:
    """Judge one UAV's result alone, without a trajectory or a mission.

    Parameters
    ----------
    scenario
        What was given.
    uav, target
        Indices of the UAV and of the target that it was sent to.
    result
        What is judged: status, path, cost and history; see `check`. However malformed it is, nothing is raised.

    Returns
    -------
    list of Violation
        Empty when nothing is wrong.

    Raises
    ------
    ValueError
        If the scenario has no such UAV or target.
    """
    for kind, index, things in (("uav", uav, scenario.uavs), ("target", target, scenario.targets)):
        if not 0 <= index < len(things):
            raise ValueError(f"scenario {scenario.name!r} has {len(things)} {kind}s, there is no {kind} {index}")
    with np.errstate(all="ignore"):
        return list(judge_result(scenario, shut_space(scenario), uav, target, result, None))


def _judge_assignment(scenario: Scenario, mission: Mission) -> list[Violation]:
    found = []
    count = len(scenario.uavs)
    if mission.scenario != scenario:
        found.append(Violation(Fault.SCENARIO, (), "The mission embeds another scenario than the one it is judged by."))
    columns = {
        "assignment": mission.assignment,
        "results": mission.results,
        "trajectories": mission.trajectories,
    }
    for noun, values in columns.items():
        if len(values) != count:
            message = f"The mission's {noun} has {len(values)} entries, but the scenario has {count} UAVs."
            found.append(Violation(Fault.ASSIGNMENT, (), message))
    takers: dict[int, int] = {}
    for uav in range(min(count, *(len(values) for values in columns.values()))):
        name = scenario.uavs[uav].name
        given, result, trajectory = mission.assignment[uav], mission.results[uav], mission.trajectories[uav]
        target = target_of(scenario, given)
        complaints = []
        if given is not None and target is None:
            complaints.append(f"is sent to target {given!r}, but targets are numbered 0 to {len(scenario.targets) - 1}")
        if target is not None and target in takers:
            other = scenario.uavs[takers[target]].name
            complaints.append(f"is sent to {scenario.targets[target].name}, which {other} already has")
        if target is not None:
            takers.setdefault(target, uav)
        if result is not None and not isinstance(result, Result):
            complaints.append(f"has a {type(result).__name__} in place of a result")
        if trajectory is not None and not isinstance(trajectory, Trajectory):
            complaints.append(f"has a {type(trajectory).__name__} in place of a trajectory")
        if given is not None and result is None:
            complaints.append("has a target but no result")
        if given is None and result is not None:
            complaints.append("has a result but no target")
        if given is None and trajectory is not None:
            complaints.append("has a trajectory but no target")
        found += [Violation(Fault.ASSIGNMENT, (uav,), f"{name} {complaint}.") for complaint in complaints]
    wanted = min(count, len(scenario.targets))
    if len(takers) < wanted and not found:
        message = (
            f"{len(takers)} UAVs have a target, but {count} UAVs and {len(scenario.targets)} targets make {wanted}."
        )
        found.append(Violation(Fault.ASSIGNMENT, (), message))
    return found
