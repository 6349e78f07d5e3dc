"""Missions as files that ground stations, maps, robots and light shows open: one file a format, told by its suffix."""

from skyverse.exports.export import export
from skyverse.exports.route import Route
from skyverse.exports.routes import routes, routes_apart

__all__ = ["Route", "export", "routes", "routes_apart"]
