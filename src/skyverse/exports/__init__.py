"""Missions as files for ground stations, maps, robots and light shows; the suffix of the file tells its format."""

from skyverse.exports.export import export
from skyverse.exports.leg_space import LegSpace
from skyverse.exports.legs import LegChecker, refused
from skyverse.exports.report import ExportCertificate, verdict_table
from skyverse.exports.requirements import ExportOptions
from skyverse.exports.route import Route
from skyverse.exports.routes import routes, routes_apart
from skyverse.exports.separation import USUAL_TOLERANCE, Apart, timed_path
from skyverse.exports.way_home import WAYS

__all__ = [
    "USUAL_TOLERANCE",
    "WAYS",
    "Apart",
    "ExportCertificate",
    "ExportOptions",
    "LegChecker",
    "LegSpace",
    "Route",
    "export",
    "refused",
    "routes",
    "routes_apart",
    "timed_path",
    "verdict_table",
]
