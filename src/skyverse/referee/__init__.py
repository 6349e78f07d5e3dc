"""The referee judges a mission by recomputing everything, and shares only the model with those who planned it.

It is slow and obvious NumPy. A scenario is turned into arrays once (`world`), and everything judges by them:

- `assignment` judges who is sent where; `result` and `path` judge results;
- `trajectory` judges trajectories at every instant: `continuity`, `clearance`, and the `limits` of the UAV;
- `timed_shapes` judges among all that changes, `separation` judges the fleet, and `mission` puts it all together.

The meaning of the data is the model's, and shared with the players (what a pad is, where a mover's doubt reaches at
t, when a zone is active); every computation is the referee's own. What is no matter of safety, such as costs, is
not judged.

`boxes`, `round_solids`, `prisms` and `ground` tell how deep a part of a curve may be inside a grown shape, `polynomial`
and `subdivision` turn that into proofs, and `tolerances` holds every tolerance.
"""

from skyverse.referee.energy import energy_bounds, judge_battery
from skyverse.referee.mission import Certificates, certify, check, check_result, judge, judged

__all__ = ["Certificates", "certify", "check", "check_result", "energy_bounds", "judge", "judge_battery", "judged"]
