"""What exports say of ways home: sentences on each UAV and the fleet, and why a mission cannot end with a return."""

from collections.abc import Iterator, Mapping, Sequence

from skyverse.errors import InputError, Remedy
from skyverse.exports.flight_plan import FlightPlan
from skyverse.exports.grouped_sentences import few, grouped
from skyverse.exports.return_choice import MAX_RALLY_POINTS
from skyverse.exports.return_home import Return
from skyverse.exports.return_lines import CLEARANCE_SHARE
from skyverse.exports.return_places import COUNTED_FROM, places_text
from skyverse.exports.separation import named_pairs
from skyverse.model.caution import Caution
from skyverse.model.scenario import Scenario
from skyverse.model.seconds import told_seconds
from skyverse.model.short_lines import counted
from skyverse.space.tube import NO_ERROR

MAX_TOLD = 3
"""Times or UAVs without a way home that one sentence tells; of more it says only how many."""


def return_sentences(
    scenario: Scenario,
    plans: Sequence[FlightPlan],
    returns: Sequence[Return | None],
    crossed: Mapping[int, Sequence[int]],
) -> Iterator[str]:
    """Yield sentences on ways home: of each UAV how it returns and where it may land, then what returns keep.

    Parameters
    ----------
    scenario, plans
        The scenario and the flight plans.
    returns
        The way home of each flight plan, ``None`` for an aeroplane.
    crossed
        By the index of each UAV that may return, the indices of those whose paths it may then come too close to.
    """
    for plan, back in zip(plans, returns, strict=True):
        name = scenario.uavs[plan.route.uav].name
        yield f"{name}: {_how(scenario, plan, back)}"
        if back is not None and back.proven:
            yield from (f"{name}: no way home {gap}." for gap in _gaps(scenario, back))
    flown = [back for back in returns if back is not None and back.proven]
    named = [(scenario.uavs[back.plan.route.uav].name, back) for back in flown]
    kept = [(name, _kept(scenario, back)) for name, back in named if not back.nowhere]
    yield from grouped(kept, len(plans))
    if len(plans) > 1:
        met = [[scenario.uavs[uav].name for uav in crossed[back.plan.route.uav]] for back in flown]
        yield from grouped([(name, _met(names)) for (name, _), names in zip(named, met, strict=True)], len(plans))


def _how(scenario: Scenario, plan: FlightPlan, back: Return | None) -> str:
    """Return at which altitude one UAV returns, when it does not, and where it may land."""
    if back is None:
        end = told_seconds(float(plan.arrivals[-1]))
        return (
            f"no way home is proven from t = 0 s to {end}, its whole flight, for it is an aeroplane: neither its "
            "return nor the circles that it flies at home; choose the altitude of its return yourself."
        )
    if not back.proven:
        return "whether it comes home by itself could not be proven."
    said = f"it returns at {back.altitude:.4g} m above {COUNTED_FROM[plan.autopilot.name]}"
    if len(back.rally):
        said += f", to the nearest of home and {counted(len(back.rally), 'rally point')}"
    said += f", but {Caution.NOT} at every instant" if len(back.lost) else ""
    return f"{said}; it may land at {places_text(scenario, back)}."


def _kept(scenario: Scenario, back: Return) -> str:
    """Return what a proven way home keeps, and when."""
    error, kept = scenario.uavs[back.plan.route.uav].tracking_error, f"{CLEARANCE_SHARE * scenario.clearance:.4g} m"
    if scenario.terrain is not None and scenario.ground_clearance < scenario.clearance:
        kept += f", above ground by {CLEARANCE_SHARE * scenario.ground_clearance:.4g} m"
    said = "when there is a way home" if len(back.lost) else "at every instant"
    said += f" the climb, the straight way home and the descent are clear by {kept}"
    if error != NO_ERROR:
        said += " and its tracking error, which in the column over home and wherever it lands counts for all but what"
        said += " lies below"
    return f"{said}."


def _met(names: Sequence[str]) -> str:
    """Return whose paths a returning UAV may cross."""
    if names:
        return f"when it returns, it may cross the paths of {', '.join(names)}."
    return "when it returns, it keeps its separation from the paths of all others."


def pairs_sentences(scenario: Scenario, together: dict[tuple[int, int], bool]) -> Iterator[str]:
    """Yield sentences on the pairs of UAVs that keep their separation when both return, and on those that may not."""
    for apart, said in (
        (True, "keep their separation also when both return, each at any instant: their ways home are apart in space"),
        (False, "apart on their ways home if one lands before the other returns"),
    ):
        pairs = [pair for pair, found in together.items() if found == apart]
        if pairs:
            named = named_pairs(scenario, pairs)
            yield f"{named} {said}." if apart else f"{Caution.ONLY} {said}: {named}."


def rally_sentences(scenario: Scenario, returns: Sequence[Return | None]) -> Iterator[str]:
    """Yield a sentence on the rally points that were added, at which UAVs may land though nobody asked for them."""
    added = [back for back in returns if back is not None and len(back.rally)]
    named = [f"{len(back.rally)} of {scenario.uavs[back.plan.route.uav].name}" for back in added]
    if named:
        yield (
            f"{Caution.BEFORE} each flight, see that rally points are free, where UAVs may land when they return: "
            f"{few(named, MAX_TOLD)}. They were added as no way to home alone is proven at every instant."
        )


def require_returns(scenario: Scenario, backs: Sequence[tuple[int, Return | None]]) -> None:
    """Raise `InputError` if any UAVs have no way home from the end of their flights, and say why.

    `backs` are the indices of UAVs and their ways home, ``None`` for aeroplanes.
    """
    planes = [scenario.uavs[uav].name for uav, back in backs if back is None]
    stay = [Remedy("end", "loiter", "to stay at the target")]
    if planes:
        raise InputError(
            f"{', '.join(planes)}: the return of an aeroplane cannot be proven, nor its circles at home",
            field="end",
            give=stay,
        )
    flown = [back for _, back in backs if back is not None]
    unsure = [back for back in flown if back.ends_safely and len(back.landings) > 1]
    if unsure:
        names = ", ".join(scenario.uavs[back.plan.route.uav].name for back in unsure)
        raise InputError(
            f"{names}: from the end, home and rally points are about equally near: it is not known where it lands",
            field="end",
            give=stay,
        )
    lost = [back for back in flown if not back.ends_safely]
    if not lost:
        return
    reasons = [_reason(scenario, back) for back in lost]
    more = f"; and {counted(len(lost) - MAX_TOLD, 'more UAV')}" if len(lost) > MAX_TOLD else ""
    raise InputError(
        f"no way home is proven from the last waypoint: {'; '.join(reasons[:MAX_TOLD])}{more}. {_advice(lost)}",
        field="end",
        give=stay,
    )


def _gaps(scenario: Scenario, back: Return) -> Iterator[str]:
    """Yield from when to when there is no way home, and what is in the way then."""
    spans = [
        f"from t = {told_seconds(begin)} to {told_seconds(end)}"
        + (", its whole flight" if back.nowhere else "")
        + (f": {why.sentence(scenario)}" if why is not None else "")
        for (begin, end), why in zip(back.lost.tolist(), back.obstructions, strict=True)
    ]
    yield from spans[:MAX_TOLD]
    if len(spans) > MAX_TOLD:
        yield f"at {len(spans) - MAX_TOLD} more times"


def _reason(scenario: Scenario, back: Return) -> str:
    """Return what is in one UAV's way home from the end of its flight, at the highest altitude that was tried."""
    name = scenario.uavs[back.plan.route.uav].name
    why = back.highest or (back.obstructions[-1] if back.proven and len(back.lost) else None)
    if why is None:
        return f"{name}: it could not be proven"
    tried = "" if back.highest is None else ", the highest that was tried,"
    counted_from = COUNTED_FROM[back.plan.autopilot.name]
    return f"{name}: at {why.altitude:.4g} m above {counted_from}{tried} {why.sentence(scenario)}"


def _advice(lost: Sequence[Return]) -> str:
    """Return a sentence on what may help UAVs without a way home."""
    met = [why for back in lost for why in back.reasons]
    helps = []
    if any(why.kind == "rule" and why.obstacle is None for why in met):
        helps.append("plan with a higher ceiling above ground")
    if any(why.kind == "rule" and why.obstacle is not None for why in met):
        helps.append("plan without the zone")
    if any(why.kind == "bounds" for why in met):
        helps.append("plan within wider bounds")
    autopilot = lost[0].plan.autopilot.name
    if MAX_RALLY_POINTS[autopilot]:
        helps.append("choose a target below which it can land")
    if autopilot == "ardupilot":
        helps.append("export for PX4, which counts its return altitude from where it lands")
    if autopilot == "dji":
        helps.append("export for PX4 or ArduPilot, which take rally points")
    advice = ", or ".join(helps)
    return advice[0].upper() + advice[1:]
