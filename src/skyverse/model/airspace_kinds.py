"""Tells obstacles that are airspace, such as no-fly zones, from those that are solid."""

AIRSPACE_WORDS = ("zone", "space", "restricted", "prohibited", "danger", "fly", "corridor", "geofence")


def is_airspace(kind: str | None) -> bool:
    """Tell whether the kind of a shape names a part of the air, on which nothing can stand."""
    return kind is not None and any(word in kind.lower() for word in AIRSPACE_WORDS)
