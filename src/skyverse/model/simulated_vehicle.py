"""Which vehicle is simulated for a fleet, and whether it is the one that the fleet was planned for."""

from collections.abc import Sequence

from skyverse.model.uav import UAV
from skyverse.model.vehicle_profiles import VEHICLE_PROFILES

DEFAULT_VEHICLE = "thesis"
"""Simulated where the fleet's vehicle has no model, where it has none, or where its UAVs have several."""


def simulated_vehicle(uavs: Sequence[UAV]) -> str:
    """Return the vehicle to simulate for the multirotors of a fleet: their own if it has a model."""
    models = {_model_of(name) for name in _planned_for(uavs)}
    return models.pop() or DEFAULT_VEHICLE if len(models) == 1 else DEFAULT_VEHICLE


def is_stand_in(vehicle: str, uavs: Sequence[UAV]) -> bool:
    """Tell whether a simulated vehicle flies in the place of another one, whose profile UAVs have."""
    return any(name and _model_of(name) != vehicle for name in _planned_for(uavs))


def simulated_vehicle_sentence(vehicle: str, uavs: Sequence[UAV]) -> str:
    """Say which vehicle is simulated, and for which other one the fleet was planned, if it was."""
    planned = _planned_for(uavs)
    named = [name for name in planned if name]
    if not named:
        return (
            f"Simulated: {vehicle}, in place of every multirotor; the mission names no vehicle. It is small and agile: "
            "a real vehicle may stray farther."
        )
    if all(_model_of(name) == vehicle for name in planned):
        return f"Simulated: {vehicle}, for which the mission was planned."
    others = [name or "UAVs without a vehicle" for name in planned if _model_of(name) != vehicle]
    why = [name for name in named if _model_of(name) is None]
    reason = f" ({', '.join(why)}: limits are known, but no mass, inertia and rotors to simulate)" if why else ""
    return (
        f"Simulated: {vehicle}, in place of every multirotor; the mission was planned for {', '.join(others)}{reason}."
    )


def _planned_for(uavs: Sequence[UAV]) -> list[str]:
    """Return the names of the multirotors' vehicles, each once; ``""`` for none."""
    return list(dict.fromkeys(uav.vehicle for uav in uavs if uav.fixed_wing is None))


def _model_of(name: str) -> str | None:
    return VEHICLE_PROFILES[name].simulated_as if name else None
