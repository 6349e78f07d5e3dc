"""What the referee can prove of a mission at every instant: of each trajectory, and of the fleet's separation."""

from typing import NamedTuple

import numpy as np

from skyverse.model.mission import Mission
from skyverse.model.scenario import Scenario
from skyverse.model.trajectory import Trajectory
from skyverse.model.verdict import Certificate, Fault, Verdict, Violation
from skyverse.referee.curve import PolynomialCurve
from skyverse.referee.separation import judge_separation
from skyverse.referee.trajectory import judge_trajectory
from skyverse.referee.untrusted import entry, target_index
from skyverse.referee.world import RefereeWorld, referee_world


class Certificates(NamedTuple):
    """What is proven of a mission.

    The certificate of each UAV's trajectory stands in the scenario's order, ``None`` where a UAV has no trajectory;
    beside them stands the certificate of the fleet's separation.
    """

    trajectories: tuple[Certificate | None, ...]
    apart: Certificate


class JudgedFleet(NamedTuple):
    """The certificates, and the violations behind them: of each UAV's trajectory, and of the fleet's separation."""

    certificates: Certificates
    trajectories: tuple[list[Violation], ...]
    apart: list[Violation]


def certify(scenario: Scenario, mission: Mission) -> Certificates:
    """Say of each trajectory, and of the fleet's separation, whether it is proven, refuted or undecided.

    What is proven holds at every instant, not only at samples: the UAV keeps the clearance from every obstacle, stays
    inside the bounds and within all its limits, flies without a jump from its start to its target, and stays out of the
    ellipsoids of all other UAVs, also before it starts and after it has arrived. Pieces of trajectories are bounded by
    their Bernstein coefficients, rounding included, and cut in two until they are decided. What is wrong by at most
    1e-6 m, or 1e-6 of a limit, is let pass.

    Parameters
    ----------
    scenario
        What was given.
    mission
        What is judged; the certificates that it carries are ignored. However malformed it is, nothing is raised.

    Returns
    -------
    Certificates
        A certificate that is refuted names the worst instant of the first thing that is wrong.
    """
    with np.errstate(all="ignore"):
        return judge_fleet(referee_world(scenario), mission).certificates


def judge_fleet(world: RefereeWorld, mission: Mission) -> JudgedFleet:
    """Judge all trajectories of a mission, and the fleet's separation."""
    scenario = world.scenario
    count = len(scenario.uavs)
    targets = [target_index(scenario, entry(mission.assignment, uav)) for uav in range(count)]
    curves: list[PolynomialCurve | None] = [None] * count
    unknown: set[int] = set()
    violations: list[list[Violation]] = [[] for _ in range(count)]
    certificates: list[Certificate | None] = [None] * count
    for uav in range(count):
        trajectory = entry(mission.trajectories, uav)
        if not isinstance(trajectory, Trajectory):
            continue
        violations[uav], halvings, curve = judge_trajectory(world, uav, targets[uav], trajectory)
        curves[uav] = curve
        if curve is None:
            unknown.add(uav)
        certificates[uav] = _certificate(violations[uav], _proven_sentence(scenario, uav, curve), halvings)
    separation = judge_separation(scenario, targets, curves, unknown)
    sentence = f"All {count} UAVs keep their separation from one another at every instant."
    apart = _certificate(separation.violations, sentence, separation.halvings)
    if unknown and apart.verdict is Verdict.PROVEN:
        names = ", ".join(scenario.uavs[uav].name for uav in sorted(unknown))
        apart = Certificate(Verdict.UNDECIDED, f"There is no telling where {names} would fly.")
    return JudgedFleet(Certificates(tuple(certificates), apart), tuple(violations), separation.violations)


def _proven_sentence(scenario: Scenario, uav: int, curve: PolynomialCurve | None) -> str:
    vehicle, knots = scenario.uavs[uav], np.zeros(2) if curve is None else curve.knots
    limits = "speed, acceleration, jerk, thrust and tilt"
    if vehicle.fixed_wing is not None:
        limits = "speed, acceleration, airspeed, turn and climb"
    ground = "" if scenario.terrain is None else f"{scenario.ground_clearance:.6g} m above ground, "
    return (
        f"{vehicle.name} is clear of every obstacle by {scenario.clearance:.6g} m, {ground}inside the bounds "
        f"and within its limits of {limits}, at every instant from t = {knots[0]:.6g} s to {knots[-1]:.6g} s."
    )


def _certificate(violations: list[Violation], proven: str, halvings: int) -> Certificate:
    """Return what the worst violation says, or that there is none.

    A violation that the planner caused comes first, one that the scenario gives second, and an undecided one last.
    """
    if not violations:
        return Certificate(Verdict.PROVEN, proven, subdivisions=halvings)
    order = {Fault.GIVEN: 1, Fault.UNDECIDED: 2}
    worst = min(violations, key=lambda violation: order.get(violation.fault, 0))
    verdict = Verdict.UNDECIDED if worst.fault is Fault.UNDECIDED else Verdict.REFUTED
    return Certificate(verdict, worst.message, worst.time, worst.position, halvings)
