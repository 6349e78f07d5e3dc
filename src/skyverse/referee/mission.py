"""Judges a mission, or the result of one of its UAVs, against the scenario: who is sent where, and what each UAV flies."""

from collections.abc import Iterator

import numpy as np

from skyverse.model.mission import Mission
from skyverse.model.result import Result, Status
from skyverse.model.scenario import Scenario
from skyverse.model.trajectory import Trajectory
from skyverse.model.verdict import Certificate, Fault, Verdict, Violation
from skyverse.referee.certificate import Certificates, judge_fleet
from skyverse.referee.result import judge_result
from skyverse.referee.untrusted import entry, target_index
from skyverse.referee.world import referee_world


def check(scenario: Scenario, mission: Mission) -> list[Violation]:
    """Judge a mission against the scenario that it answers.

    A place is safe if it lies within the closed bounds, not inside an obstacle that is grown by the clearance on every
    side (a grown box is a box), and no lower above ground than the terrain's clearance. What is wrong by at most 1e-6 m
    (or m/s, or relative) is let pass.

    Parameters
    ----------
    scenario
        What was given; the scenario that the mission embeds must be equal to it.
    mission
        What is judged. However malformed it is, violations are returned and nothing is raised.

    Returns
    -------
    list of Violation
        Empty when nothing is wrong, and all trajectories and their separation are proven; see `certify`. There is at
        most one violation of each kind for a trajectory, at its worst instant, and for a pair of UAVs too close to each
        other.

    Notes
    -----
    *Not judged* are claims that only another search could refute: that there is no path, that no path is cheaper (the
    bound, and the status "optimal"), that a start or target is unsafe or shut in; nor the seconds and effort spent.

    *Exact* are the judgements of assignment, statuses, costs, path segments, and of ends and continuity at the knots.

    *Proven* at every instant are clearance, bounds and limits of trajectories, and separations. What is neither proven
    nor refuted is a violation too, `Fault.UNDECIDED`. The mission's own certificates are not trusted: a certificate
    that says "proven" where the referee does not is a violation, `Fault.STATUS`.
    """
    return judge(scenario, mission)[0]


def judge(scenario: Scenario, mission: Mission) -> tuple[list[Violation], Certificates]:
    """Return what `check` and `certify` return, at the price of one of them."""
    with np.errstate(all="ignore"):
        world = referee_world(scenario)
        violations = _judge_assignment(scenario, mission)
        fleet = judge_fleet(world, mission)
        for uav in range(len(scenario.uavs)):
            target = target_index(scenario, entry(mission.assignment, uav))
            result, trajectory = entry(mission.results, uav), entry(mission.trajectories, uav)
            if isinstance(result, Result):
                if result.status is Status.NOT_PLANNED and not mission.interrupted:
                    message = f"{scenario.uavs[uav].name} was not planned, but the mission was not interrupted."
                    violations.append(Violation(Fault.STATUS, (uav,), message))
                violations += judge_result(world, uav, target, result, isinstance(trajectory, Trajectory))
            violations += fleet.trajectories[uav]
        violations += [*fleet.apart, *_judge_claims(scenario, mission, fleet.certificates)]
        return violations, fleet.certificates


def check_result(scenario: Scenario, uav: int, target: int, result: Result) -> list[Violation]:
    """Judge one UAV's result alone, without a trajectory or a mission.

    Parameters
    ----------
    scenario
        What was given.
    uav, target
        The indices of the UAV and of the target that it was sent to.
    result
        What is judged: its status, path, cost and history; see `check`. However malformed it is, nothing is raised.

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
        return list(judge_result(referee_world(scenario), uav, target, result, None))


def _judge_claims(scenario: Scenario, mission: Mission, true: Certificates) -> Iterator[Violation]:
    """Yield which of the mission's own certificates say "proven" where the referee does not."""
    own = mission.certificates if isinstance(mission.certificates, tuple | list) else ()
    claims = [(f"{uav.name}'s trajectory", (k,), entry(own, k)) for k, uav in enumerate(scenario.uavs)]
    fleet = ("the fleet's separation", (), mission.apart)
    for (noun, uavs, claim), known in zip([*claims, fleet], [*true.trajectories, true.apart], strict=True):
        proven = known is not None and known.verdict is Verdict.PROVEN
        if isinstance(claim, Certificate) and claim.verdict is Verdict.PROVEN and not proven:
            verdict = "not there" if known is None else f"{known.verdict.value}"
            yield Violation(Fault.STATUS, uavs, f"The mission says that {noun} is proven, but it is {verdict}.")


def _judge_assignment(scenario: Scenario, mission: Mission) -> list[Violation]:
    """Return what is wrong with who is sent where, and with which results and trajectories there are."""
    found = []
    count = len(scenario.uavs)
    if mission.scenario != scenario:
        found.append(Violation(Fault.SCENARIO, (), "The mission embeds another scenario than the one it is judged by."))
    columns = {noun: getattr(mission, noun) for noun in ("assignment", "results", "trajectories")}
    for noun, values in columns.items():
        if len(values) != count:
            message = f"The mission's {noun} has {len(values)} entries, but the scenario has {count} UAVs."
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
        message = f"{len(takers)} UAVs have a target, but {count} UAVs and {targets} targets make {wanted}."
        found.append(Violation(Fault.ASSIGNMENT, (), message))
    return found
