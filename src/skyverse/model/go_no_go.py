"""One verdict on a mission for whoever is to fly it: go, or no go and why."""

from dataclasses import dataclass

from skyverse.model.mission import Mission
from skyverse.model.short_lines import counted, listed
from skyverse.model.verdict import Verdict


@dataclass(frozen=True)
class GoNoGo:
    """Whether a mission can be flown, and whether all that was asked of it is proven.

    Attributes
    ----------
    go
        Whether flights and photos are proven.
    verdict
        On all that was asked: undecided where something of it was not judged.
    sentence
        Both in one sentence.
    """

    go: bool
    verdict: Verdict
    sentence: str


def go_no_go(mission: Mission) -> GoNoGo:
    """Return the verdict on a mission: on its flights, and on what its surveys ask for."""
    surveys, proof = mission.scenario.surveys, {one.survey: one.verdict for one in mission.coverage}
    flights = {one.verdict for one in (*mission.certificates, mission.apart) if one is not None}
    wrong = [f"the referee found {counted(len(mission.violations), 'thing')} wrong"] if mission.violations else []
    wrong += [] if mission.complete else [mission.missing]
    wrong += [f"{surveys[k].name} is not photographed as asked" for k, one in proof.items() if one is Verdict.REFUTED]
    open_ = [] if mission.apart or wrong else ["the mission has not been judged"]
    open_ += ["not every flight is proven"] if flights - {Verdict.PROVEN} and not wrong else []
    unsure = [one.name for k, one in enumerate(surveys) if proof.get(k, Verdict.UNDECIDED) is Verdict.UNDECIDED]
    open_ += [f"the photos of {listed(unsure)} are not proven"] if unsure and flights else []
    if wrong or open_:
        return GoNoGo(False, Verdict.REFUTED if wrong else Verdict.UNDECIDED, f"No go: {listed([*wrong, *open_])}.")
    if unjudged := [one.name for one in surveys if one.overlaps_on_walls]:
        return GoNoGo(True, Verdict.UNDECIDED, f"Go, but how much photos of {listed(unjudged)} overlap is not judged.")
    return GoNoGo(True, Verdict.PROVEN, "Go: all that was asked is proven.")
