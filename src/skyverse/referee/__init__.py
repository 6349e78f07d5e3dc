"""The referee judges a mission by recomputing everything, and shares no code with those who planned it.

It is slow and obvious NumPy. A scenario is turned into arrays once (`world`), and everything judges by them:

- `assignment` judges who is sent where; `result`, `path` and `path_cost` with `soft_terms` and `zones` judge results;
- `trajectory` judges trajectories at every instant: `continuity`, `clearance`, and the `limits` of the UAV;
- `separation` judges the fleet; `certificate` states what is proven, and `mission` puts it all together.

`boxes`, `round_solids`, `prisms` and `ground` tell how deep a part of a curve may be inside a grown shape, `polynomial`
and `subdivision` turn that into proofs, and `tolerances` holds every tolerance.
"""

from skyverse.referee.mission import Certificates, certify, check, check_result, judge

__all__ = ["Certificates", "certify", "check", "check_result", "judge"]
