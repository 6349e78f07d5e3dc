"""The referee's judgement of a mission before it is exported: what is refuted is refused, what is undecided is told."""

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

from skyverse.errors import InputError, Remedy
from skyverse.model.caution import Caution
from skyverse.model.mission import Mission
from skyverse.model.scenario import Scenario
from skyverse.model.verdict import Fault, Violation
from skyverse.referee import judge

TOO_CLOSE = (Fault.SEPARATION, Fault.GIVEN)
"""What is wrong between two UAVs, which a caller may allow."""


def require_not_refuted(
    mission: Mission, scenario: Scenario, path: Path, *, allow_close: bool
) -> tuple[list[str], Mission]:
    """Let the referee judge a mission; return in sentences what it has not proven, and the mission with its verdict.

    Parameters
    ----------
    mission
        What is to be exported. The certificates and violations that it carries are not believed.
    scenario
        What it is judged by.
    path
        The file to write, which messages name.
    allow_close
        Whether UAVs may come too close to each other.

    Raises
    ------
    InputError
        If the referee refutes the mission.
    """
    violations, (certificates, apart) = judge(scenario, mission)
    close = [one for one in violations if one.fault in TOO_CLOSE]
    doubtful = [one for one in violations if one.fault is Fault.UNDECIDED]
    wrong = [one for one in violations if one.fault not in (*TOO_CLOSE, Fault.UNDECIDED)]
    if wrong or (close and not allow_close):
        remedy = Remedy("allow_close", True, "to export it all the same")
        said = f"{path}: the referee refutes this mission: {_told(wrong + close)}; skyverse check tells all of it"
        raise InputError(said, give=[] if wrong else [remedy])
    notes = [f"{Caution.NOT} apart, as the referee finds: {_told(close)}."] if close else []
    notes += [f"{Caution.NOT} proven by the referee: {_told(doubtful)}."] if doubtful else []
    return notes, replace(mission, violations=tuple(violations), certificates=certificates, apart=apart)


def _told(violations: Sequence[Violation]) -> str:
    """Return the message of the first violation, without its full stop, and how many more there are."""
    more = f" (and {len(violations) - 1} more)" if len(violations) > 1 else ""
    return violations[0].message.removesuffix(".") + more
