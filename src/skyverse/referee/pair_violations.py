"""What violations say of two UAVs that come too close, or of which that could not be decided."""

import numpy as np

from skyverse._typing import Indices
from skyverse.model.verdict import Fault, Violation
from skyverse.referee.pair_motion import FleetSeparation, Meeting, SharedPieces
from skyverse.referee.positions import position_text, position_tuple
from skyverse.referee.subdivision import Peaks
from skyverse.referee.tolerances import LET_PASS


def unproven(fleet: FleetSeparation, pair: Indices, pieces: SharedPieces, peaks: Peaks, k: int) -> Violation:
    """Return what is wrong with a pair of UAVs, whose separation is the k-th question and was not proven."""
    place = peaks.stuck[k], peaks.stuck_share[k]
    if peaks.refuted[k]:
        place = peaks.piece[k], peaks.share[k]
        meeting, share = fleet.meeting(pieces, *place), float(pieces.share[place[0]])
        if fleet.nearness(pair, meeting, share, LET_PASS) < 1:
            why = ", nearer than their starts or targets are given" if share < 1 else ""
            return too_close(fleet, pair, meeting, Fault.SEPARATION, why)
    return _undecided(fleet, pair, fleet.meeting(pieces, *place), int(peaks.halvings[k]))


def too_close(fleet: FleetSeparation, pair: Indices, meeting: Meeting, fault: Fault, why: str) -> Violation:
    """Return the violation of a pair at a meeting; `why` is added to the message."""
    i, j = (int(k) for k in pair)
    time, first, second = meeting
    middle, metres = (first + second) / 2, float(np.linalg.norm(first - second))
    deed = f"come within {metres:.6g} m of each other"
    if time == 0:
        deed = f"are {metres:.6g} m apart already at the start,"
    message = (
        f"{_names(fleet, i, j)} {deed} at t = {time:.6g} s, around {position_text(middle)}{why}: "
        f"{fleet.nearness(pair, meeting):.6g} of the separation, {fleet.across[i, j]:.6g} m to the side and "
        f"{fleet.above[i, j]:.6g} m above."
    )
    return Violation(fault, _uavs(fleet, i, j), message, time, position_tuple(middle))


def _undecided(fleet: FleetSeparation, pair: Indices, meeting: Meeting, halvings: int) -> Violation:
    i, j = (int(k) for k in pair)
    middle = (meeting.first + meeting.second) / 2
    message = (
        f"Whether {_names(fleet, i, j)} keep their separation could not be decided at t = {meeting.time:.6g} s, "
        f"around {position_text(middle)}, by cutting pieces in two {halvings} times."
    )
    return Violation(Fault.UNDECIDED, _uavs(fleet, i, j), message, meeting.time, position_tuple(middle))


def _uavs(fleet: FleetSeparation, i: int, j: int) -> tuple[int, int]:
    return fleet.motion.uavs[i], fleet.motion.uavs[j]


def _names(fleet: FleetSeparation, i: int, j: int) -> str:
    return " and ".join(fleet.scenario.uavs[uav].name for uav in _uavs(fleet, i, j))
