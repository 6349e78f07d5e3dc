"""Replanning policies by name: ways in which a UAV in flight finds its way anew."""

import importlib
from dataclasses import fields
from typing import TYPE_CHECKING

from skyverse.errors import InputError

if TYPE_CHECKING:
    from skyverse.live.policies.policy import Policy

_CLASSES = {
    "from-scratch": "planner_policies.FromScratch",
    "kept-population": "planner_policies.KeptPopulation",
    "velocity-obstacles": "velocity_obstacles.VelocityObstacles",
    "wait": "policy.Wait",
}

POLICY_NAMES = tuple(_CLASSES)
"""The names of the policies in files."""


def make_policy(name: str, **settings: object) -> "Policy":
    """Return the policy of that name with these settings.

    Raises
    ------
    InputError
        If there is no such policy or setting, or a setting has a value that it cannot have.
    """
    if name not in _CLASSES:
        raise InputError(f"there is no policy {name!r}; there are {', '.join(POLICY_NAMES)}")
    module, _, cls = _CLASSES[name].partition(".")
    made = getattr(importlib.import_module(f"{__name__}.{module}"), cls)
    known = [field.name for field in fields(made)]
    unknown = [setting for setting in settings if setting not in known]
    if unknown:
        has = f"{made.__name__} has {', '.join(known) or 'none'}"
        raise InputError(f"there is no setting {', '.join(map(repr, unknown))}; {has}")
    return made(**settings)
