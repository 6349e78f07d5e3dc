"""Files that tell autopilots what to do: read as `Waypoints`, written with changes, and made anew for exports."""

from skyverse.orders.files import is_waypoint_file, read_waypoints, require_same_format, rewritten, write_waypoints

__all__ = ["is_waypoint_file", "read_waypoints", "require_same_format", "rewritten", "write_waypoints"]
