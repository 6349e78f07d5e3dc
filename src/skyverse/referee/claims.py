"""Judges what a mission says of itself: its certificates, and how its conflicts were resolved."""

from collections.abc import Iterator, Sequence

import numpy as np

from skyverse.model.digest import short
from skyverse.model.mission import Mission
from skyverse.model.scenario import Scenario
from skyverse.model.verdict import Certificate, Deconfliction, Fault, Verdict, Violation
from skyverse.referee.curve import PolynomialCurve
from skyverse.referee.path import costs_agree
from skyverse.referee.untrusted import entry, number


def judge_claims(
    scenario: Scenario, mission: Mission, trajectories: Sequence[Certificate | None], apart: Certificate
) -> Iterator[Violation]:
    """Yield which certificates in the mission say "proven" where the referee's do not, or are of another scenario."""
    own = mission.certificates if isinstance(mission.certificates, tuple | list) else ()
    digest = apart.scenario
    claims = [(f"{uav.name}'s trajectory", (k,), entry(own, k)) for k, uav in enumerate(scenario.uavs)]
    fleet = ("the fleet's separation", (), mission.apart)
    for (noun, uavs, claim), known in zip([*claims, fleet], [*trajectories, apart], strict=True):
        proven = known is not None and known.verdict is Verdict.PROVEN
        if isinstance(claim, Certificate) and claim.verdict is Verdict.PROVEN and not proven:
            verdict = "not there" if known is None else f"{known.verdict.value}"
            yield Violation(Fault.STATUS, uavs, f"The mission says that {noun} is proven, but it is {verdict}.")
        if isinstance(claim, Certificate) and claim.scenario not in ("", digest):
            message = f"The mission's certificate of {noun} was made for another scenario, {short(claim.scenario)}."
            yield Violation(Fault.STATUS, uavs, message)


def judge_deconfliction(
    scenario: Scenario, mission: Mission, curves: Sequence[PolynomialCurve | None]
) -> Iterator[Violation]:
    """Yield what the record of a fleet's deconfliction says that its trajectories do not do.

    Judged are the times after deconfliction, and whether the UAVs that the record names exist; what was before is not
    in the mission any more.
    """
    record = mission.deconfliction
    if not isinstance(record, Deconfliction):
        return
    strangers = [uav for uav in _named_uavs(record) if not _is_index(uav, len(scenario.uavs))]
    if strangers:
        message = f"The deconfliction names UAV {strangers[0]!r}, but UAVs are numbered 0 to {len(scenario.uavs) - 1}."
        yield Violation(Fault.DECONFLICTION, (), message)
    ends = [float(curve.knots[-1]) for curve in curves if curve is not None]
    times = (
        ("sum of arrival times", record.total_after, sum(ends)),
        ("last arrival", record.makespan_after, max(ends, default=0.0)),
    )
    for noun, claimed, true in times:
        if not costs_agree(number(claimed), true):
            message = f"The deconfliction says that the {noun} is {number(claimed):.9g} s, but it is {true:.9g} s."
            yield Violation(Fault.DECONFLICTION, (), message)


def _named_uavs(record: Deconfliction) -> Iterator[object]:
    """Yield the UAVs that a record names; ``None`` for each entry that names none because it is malformed."""
    for conflict in (*_entries(record.found), *_entries(record.left)):
        yield from _entries(getattr(conflict, "uavs", None))
    for action in _entries(record.actions):
        yield getattr(action, "uav", None)


def _is_index(value: object, count: int) -> bool:
    return isinstance(value, int | np.integer) and 0 <= int(value) < count


def _entries(values: object) -> Sequence[object]:
    """Return the entries of a tuple or list, and one ``None`` in place of anything else."""
    return values if isinstance(values, tuple | list) else (None,)
