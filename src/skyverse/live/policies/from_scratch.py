"""A planner asked anew at every observation, which remembers nothing of its last answer."""

from dataclasses import dataclass

from skyverse.live.policies.planner_policy import PlannerPolicy, planned, problem_now
from skyverse.live.policies.policy import Found, Situation
from skyverse.stop import MaxPaths


@dataclass(frozen=True, kw_only=True)
class FromScratch(PlannerPolicy):
    """A planner asked anew at every observation, which remembers nothing of its last answer."""

    def find(self, situation: Situation) -> Found:
        """Return the planner's way."""
        problem = problem_now(situation, self.sweep, self.timed)
        return Found(*planned(problem, self.made().plan(problem, stop=MaxPaths(self.paths), rng=situation.rng)))
