"""Standing still until the way is free."""

from dataclasses import dataclass

from skyverse.live.policies.policy import NO_EFFORT, Found, Policy, Situation


@dataclass(frozen=True, kw_only=True)
class Wait(Policy):
    """Go on along the mission's own path as soon as that is proven, and stand still until then."""

    def find(self, situation: Situation) -> Found:
        """Return what is left of the mission's path."""
        return Found(situation.guidance, NO_EFFORT)
