"""Where and when two UAVs come too close to each other, and how that is resolved."""

from skyverse.deconfliction.among_movers import STAY, clear_departure, meets_movers
from skyverse.deconfliction.candidate import Candidate, Gate, PlacedFlight
from skyverse.deconfliction.curve_store import CurveStore, grow_tree
from skyverse.deconfliction.curves import Schedule, TimedCurve, make_curves, position_at
from skyverse.deconfliction.find_conflicts import conflict_spans, find_conflicts, in_conflict
from skyverse.deconfliction.forbidden_departures import TICK, free_departures
from skyverse.deconfliction.paths_apart import apart_by_timing_only
from skyverse.deconfliction.resolve_conflicts import resolve_conflicts

__all__ = [
    "STAY",
    "TICK",
    "Candidate",
    "CurveStore",
    "Gate",
    "PlacedFlight",
    "Schedule",
    "TimedCurve",
    "apart_by_timing_only",
    "clear_departure",
    "conflict_spans",
    "find_conflicts",
    "free_departures",
    "grow_tree",
    "in_conflict",
    "make_curves",
    "meets_movers",
    "position_at",
    "resolve_conflicts",
]
