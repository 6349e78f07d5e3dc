"""Missions as files for ground stations, maps, robots and light shows; the suffix of the file tells its format."""

from skyverse.exports.export import export
from skyverse.exports.route import Route
from skyverse.exports.routes import routes, routes_apart

__all__ = ["Route", "export", "routes", "routes_apart"]
