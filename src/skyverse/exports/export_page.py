"""The page of an export: the mission as it is drawn, where UAVs may land, and all that is proven of the waypoints."""

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

from skyverse.atomic import write_text
from skyverse.draw.mission_page import page
from skyverse.draw.scene import LandingPlace, scene
from skyverse.exports.flight_verdicts import verdict_table
from skyverse.exports.global_positions import origin_of
from skyverse.exports.way_home import WayHome
from skyverse.exports.waypoint_files import ExportCertificate
from skyverse.model.geodesy import to_wgs84
from skyverse.model.mission import Mission
from skyverse.model.scenario import Scenario


def write_export_page(path: Path, mission: Mission, certificate: ExportCertificate, notes: Sequence[str]) -> None:
    """Write the page of an export.

    Parameters
    ----------
    path
        The file.
    mission
        The mission with the referee's verdict, in a scenario with an origin.
    certificate
        What is proven of the waypoints.
    notes
        What the export says, in sentences.
    """
    landings = tuple(_home(mission.scenario, back) for back in certificate.returns if back is not None)
    head, rows = verdict_table(certificate.flights)
    told = replace(scene(mission), landings=landings, export_notes=tuple(notes), export_verdicts=(head, *rows))
    write_text(path, page(told))


def _home(scenario: Scenario, back: WayHome) -> LandingPlace:
    """Return where a UAV lands when it returns, as it is drawn."""
    uav, (x, y, _) = back.plan.route.uav, back.plan.route.points[0].tolist()
    latitude, longitude, ground = to_wgs84(origin_of(scenario), back.plan.home[None])[0].tolist()
    words = (
        f"{scenario.uavs[uav].name}: home, {latitude:.6f}, {longitude:.6f}, {ground:z.1f} m above mean sea level; it "
        f"returns there {back.altitude:.4g} m above it, or higher"
    )
    return LandingPlace(uav, words, (x, y, float(back.plan.home[2])), back.level)
