"""What the referee can say of a mission at every instant: of each trajectory, and of the fleet's separation."""

from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np

from skyverse.model.mission import Mission
from skyverse.model.scenario import Scenario
from skyverse.model.trajectory import Trajectory
from skyverse.model.verdict import Certificate, Fault, Verdict, Violation
from skyverse.referee.boxes import GROUND, keeps
from skyverse.referee.clearance import Space, shut_space
from skyverse.referee.curve import Curve
from skyverse.referee.flight import judge_trajectory
from skyverse.referee.separation import judge_separation


class Certificates(NamedTuple):
    """What is proven of a mission.

    Of each UAV's trajectory in the scenario's order, ``None`` where it has none; and of the fleet's separation.
    """

    trajectories: tuple[Certificate | None, ...]
    apart: Certificate


class Findings(NamedTuple):
    """The certificates, and the violations behind them: of each UAV's trajectory, and of the fleet's separation."""

    certificates: Certificates
    trajectories: tuple[list[Violation], ...]
    apart: list[Violation]


def certify(scenario: Scenario, mission: Mission) -> Certificates:
    """Say of each trajectory, and of the fleet's separation, whether it is proven, refuted or undecided.

    Proven is what holds at every instant, not only at samples: clear of every obstacle by the clearance, inside the
    bounds, within every limit of the UAV, joined without a jump, from its start to its target; and outside the
    ellipsoids of all other UAVs, also before a start and after an end. Pieces are bounded by their Bernstein
    coefficients, rounding included, and cut in two until they are decided. What is wrong by at most 1e-6 m, or 1e-6 of
    a limit, is let pass.

    Parameters
    ----------
    scenario
        What was given.
    mission
        What is judged; the certificates that it carries are not looked at. However malformed it is, nothing is raised.

    Returns
    -------
    Certificates
        Those refuted name the worst instant of the first thing that is wrong.
    """
    with np.errstate(all="ignore"):
        return judge_flight(scenario, shut_space(scenario), mission).certificates


def judge_flight(scenario: Scenario, space: Space, mission: Mission) -> Findings:
    """Judge all trajectories, and the fleet's separation."""
    count = len(scenario.uavs)
    targets = [target_of(scenario, entry(mission.assignment, uav)) for uav in range(count)]
    curves: list[Curve | None] = [None] * count
    unknown: set[int] = set()
    violations: list[list[Violation]] = [[] for _ in range(count)]
    certificates: list[Certificate | None] = [None] * count
    for uav in range(count):
        trajectory = entry(mission.trajectories, uav)
        if not isinstance(trajectory, Trajectory):
            continue
        judged = judge_trajectory(scenario, space, uav, targets[uav], trajectory)
        violations[uav], curves[uav] = judged.violations, judged.curve
        if judged.curve is None:
            unknown.add(uav)
        certificates[uav] = _certificate(judged.violations, _sound(scenario, uav, judged.curve), judged.halvings)
    apart = judge_separation(scenario, targets, curves, unknown)
    sentence = f"All {count} UAVs keep their separation from one another at every instant."
    fleet = _certificate(apart.violations, sentence, apart.halvings)
    if unknown and fleet.verdict is Verdict.PROVEN:
        names = ", ".join(scenario.uavs[uav].name for uav in sorted(unknown))
        fleet = Certificate(Verdict.UNDECIDED, f"There is no telling where {names} would fly.")
    return Findings(Certificates(tuple(certificates), fleet), tuple(violations), apart.violations)


def entry(values: Sequence[Any], index: int) -> Any:
    """Return one UAV's entry in a column of a mission, ``None`` where it is too short."""
    return values[index] if index < len(values) else None


def target_of(scenario: Scenario, index: object) -> int | None:
    """Return the index of a target that exists, ``None`` for anything else."""
    if isinstance(index, bool) or not isinstance(index, int | np.integer):
        return None
    return int(index) if 0 <= index < len(scenario.targets) else None


def _sound(scenario: Scenario, uav: int, curve: Curve | None) -> str:
    vehicle, knots = scenario.uavs[uav], np.zeros(2) if curve is None else curve.knots
    limits = "speed, acceleration, jerk, thrust and tilt"
    if vehicle.fixed_wing is not None:
        limits = "speed, acceleration, airspeed, turn and climb"
    ground = "" if scenario.terrain is None else f"{keeps(scenario, GROUND):.6g} m above ground, "
    return (
        f"{vehicle.name} is clear of every obstacle by {scenario.clearance:.6g} m, {ground}inside the bounds "
        f"and within its limits of {limits}, at every instant from t = {knots[0]:.6g} s to {knots[-1]:.6g} s."
    )


def _certificate(violations: list[Violation], sound: str, halvings: int) -> Certificate:
    """Return what the worst violation says: one that is refuted and nobody could help comes after others."""
    if not violations:
        return Certificate(Verdict.PROVEN, sound, subdivisions=halvings)
    order = {Fault.GIVEN: 1, Fault.UNDECIDED: 2}
    worst = min(violations, key=lambda violation: order.get(violation.fault, 0))
    verdict = Verdict.UNDECIDED if worst.fault is Fault.UNDECIDED else Verdict.REFUTED
    return Certificate(verdict, worst.message, worst.time, worst.position, halvings)
