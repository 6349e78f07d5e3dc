"""Files that tell autopilots what to do: read as `Waypoints`, written with changes, and made anew for exports."""

from skyverse.orders.files import read_waypoints, require_same_format, rewritten, write_waypoints

__all__ = ["read_waypoints", "require_same_format", "rewritten", "write_waypoints"]
