"""A scenario that has a part of every kind, and its parts one by one, changed by ways around validation."""

from collections.abc import Iterator
from typing import Any

from pydantic import BaseModel

import skyverse as sky
from skyverse.model.quantities import Model, derived

Place = tuple[str | int, ...]
"""Field names and indices that lead from a scenario to something in it."""

EVERY_PART = sky.Scenario.model_validate(
    {
        "name": "everything",
        "bounds": {"min": [0, 0, 0], "max": [20, 20, 10]},
        "clearance": 0.25,
        "max_height": 9.5,
        "wind": {
            "layers": [{"altitude": 0, "velocity": [1, 0, 0]}, {"altitude": 10, "velocity": [1.5, 0.5, 0]}],
            "gust": 0.2,
        },
        "lattice": {"step": [1, 1, 1]},
        "terrain": {"origin": [0, 0], "step": [20, 20], "heights": [[0, 0.1], [0, 0]], "clearance": 0.5},
        "obstacles": [
            {"min": [3, 3, 0], "max": [4, 4, 5], "kind": "building"},
            {"shape": "cylinder", "centre": [6, 6], "radius": 0.5, "low": 0, "high": 4, "closed_above": True},
            {"shape": "sphere", "centre": [8, 3, 3], "radius": 0.5},
            {"shape": "prism", "vertices": [[10, 10], [12, 10], [11, 12]], "low": 0, "high": 3},
            {"shape": "voxels", "origin": [14, 14, 0], "step": [1, 1, 1], "occupied": [[[1, 0]], [[0, 1]]]},
        ],
        "zones": [
            {"min": [0, 15, 0], "max": [4, 18, 5], "risk": 2.0},
            {"min": [5, 15, 0], "max": [8, 18, 5], "max_speed": 1.5, "active": [[None, 3], [9, 12]]},
        ],
        "movers": [
            {
                "shape": {"min": [-0.2, -0.2, -0.2], "max": [0.2, 0.2, 0.2]},
                "motion": {"points": [[18, 2, 5], [18, 8, 5]], "times": [0, 30]},
                "doubt": {"radius": 0.1, "growth": 0.1, "acceleration": 0.1, "since": 0.0, "top_speed": 1.0},
            },
            {
                "shape": {"shape": "sphere", "centre": [0, 0, 0], "radius": 0.2},
                "motion": {"motion": "circle", "centre": [17, 17, 8], "radius": 1.0, "period": 30.0, "bearing": 90},
            },
            {
                "shape": {"shape": "cylinder", "centre": [0, 0], "radius": 0.2, "low": 0, "high": 1},
                "motion": {
                    "motion": "periodic",
                    "centre": [17, 12, 8], "period": 30, "cosine": [[1, 0, 0]], "sine": [[0, 1, 0]],
                },
            },
            {
                "shape": {"shape": "ellipsoid", "centre": [0, 0, 0], "semi_axis_xy": 0.2, "semi_axis_z": 0.4},
                "motion": {"motion": "polynomials", "knots": [0, 9], "coefficients": [[[12, 17, 8], [0.1, 0, 0]]]},
            },
        ],
        "objective": {
            "unit": "metres",
            "altitude": {"low": 1, "high": 8, "weight": 0.1, "above": "ground"},
            "climb": {"angle": 60, "weight": 0.1},
        },
        "uavs": [
            {
                "start": [1, 1, 2], "home": 0.5, "end": "home", "max_climb": 2, "max_descent": 2, "look_at": [9, 9, 0],
                "vertical_separation": 0.9, "hover_power": 90, "tracking_error": {"horizontal": 0.1, "vertical": 0.1},
            },
            {
                "start": [1, 10, 5], "end": "home", "max_speed": 5, "max_acceleration": 5,
                "fixed_wing": {"speed": 4, "turn_radius": 5, "climb": 10},
            },
        ],
        "targets": [{"position": [1, 6, 2]}, {"position": [9, 14, 5]}],
        "surveys": [{"area": [[0, 5], [9, 5], [9, 15]], "camera": "mavic-3e", "gsd": "2 cm"}],
        "frame": {"origin": {"latitude": 46.8, "longitude": 9.8, "altitude": 1500, "geoid": 50}},
        "sources": [{"file": "a.tif", "gives": "terrain"}],
    }
)  # fmt: skip


def models_in(model: Model) -> Iterator[Model]:
    """Yield a model and all models in it."""
    yield model
    for value in vars(model).values():
        for part in value if isinstance(value, tuple) else (value,):
            if isinstance(part, Model):
                yield from models_in(part)


def numbers_in(value: object, place: Place = ()) -> Iterator[Place]:
    """Yield the places of all numbers in a model that are neither whole nor in an array."""
    entries: Any = (
        vars(value).items() if isinstance(value, Model) else enumerate(value) if isinstance(value, tuple) else ()
    )
    for key, entry in entries:
        if isinstance(entry, float):
            yield (*place, key)
        yield from numbers_in(entry, (*place, key))


def unsound(value: Any, place: Place, other: object) -> Any:
    """Return a model with something else at a place, validated by nobody."""
    if not place:
        return other
    key, *further = place
    if isinstance(value, BaseModel):
        return derived(value, **{str(key): unsound(getattr(value, str(key)), tuple(further), other)})
    assert isinstance(key, int)
    return (*value[:key], unsound(value[key], tuple(further), other), *value[key + 1 :])
