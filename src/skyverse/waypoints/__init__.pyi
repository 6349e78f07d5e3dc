"""The face of missions that people have; see `skyverse.waypoints`."""

from .changes import Change as Change
from .check import CheckedMission as CheckedMission
from .findings import FindingKind as FindingKind
from .findings import MissionFinding as MissionFinding
from .findings import Subject as Subject
from .fleet import CheckedFleet as CheckedFleet
from .fleet import check_waypoints as check_waypoints
from .repair import RepairedFleet as RepairedFleet
from .repair import repair_waypoints as repair_waypoints
