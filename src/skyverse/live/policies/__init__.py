"""Replanning policies by name: ways in which a UAV in flight finds its way anew."""

from collections.abc import Mapping
from dataclasses import fields

from skyverse.errors import InputError, did_you_mean, shown
from skyverse.live.policies.planner_policies import FromScratch, KeptPopulation
from skyverse.live.policies.policy import Policy, Wait
from skyverse.live.policies.velocity_obstacles import VelocityObstacles

POLICIES: dict[str, type[Policy]] = {
    "from-scratch": FromScratch,
    "kept-population": KeptPopulation,
    "velocity-obstacles": VelocityObstacles,
    "wait": Wait,
}
"""The policies by their names in files."""


def make_policy(name: str, **settings: object) -> Policy:
    """Return the policy of that name with these settings.

    Raises
    ------
    InputError
        If there is no such policy or setting, or a setting has a value that it cannot have.
    """
    if name not in POLICIES:
        near = did_you_mean(name, POLICIES) or f"; there are {', '.join(POLICIES)}"
        raise InputError(f"there is no policy {name!r}{near}")
    known = [field.name for field in fields(POLICIES[name])]
    unknown = [setting for setting in settings if setting not in known]
    if unknown:
        has = f"{POLICIES[name].__name__} has {', '.join(known) or 'none'}"
        raise InputError(f"there is no setting {', '.join(map(repr, unknown))}; {has}")
    return POLICIES[name](**settings)


def policy_of(given: object) -> Policy:
    """Return a policy that is given as such, by its name, or by a mapping of its name and its settings, as in files."""
    settings = {"policy": given} if isinstance(given, str) else given
    if isinstance(settings, Mapping) and isinstance(settings.get("policy"), str):
        return make_policy(settings["policy"], **{key: value for key, value in settings.items() if key != "policy"})
    if not isinstance(given, Policy):
        said = f"expected the name of a policy, or a mapping of it and its settings, found {shown(given)}"
        raise InputError(said, field="policy")
    return given
