"""The page of an export: the mission as it is drawn, where UAVs may land, and all that is proven of the waypoints."""

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

from skyverse.atomic import write_text
from skyverse.draw.landing_place import LandingPlace
from skyverse.draw.mission_page import page
from skyverse.draw.scene import scene
from skyverse.exports.flight_verdicts import verdict_table
from skyverse.exports.return_home import Return
from skyverse.exports.return_places import return_places
from skyverse.exports.waypoint_files import ExportCertificate
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
    landings = [
        place
        for back in certificate.returns
        if back is not None and back.proven
        for place in _landings(mission.scenario, back)
    ]
    drawn = scene(mission)
    head, rows = verdict_table(certificate.flights)
    told = replace(drawn, landings=tuple(landings), export_notes=tuple(notes), export_verdicts=(head, *rows))
    write_text(path, page(told))


def _landings(scenario: Scenario, back: Return) -> list[LandingPlace]:
    """Return where one UAV may land, as it is drawn."""
    uav, way = back.plan.route.uav, back.way
    drawn = []
    for told, (x, y, z), level in zip(return_places(scenario, back), way.places.tolist(), way.levels, strict=True):
        words = (
            f"{scenario.uavs[uav].name}: {told.name}, {told.latitude:.6f}, {told.longitude:.6f}, {told.ground:z.1f} m "
            f"above mean sea level; it returns there at {told.level:z.1f} m or higher"
        )
        drawn.append(LandingPlace(uav, words, (x, y, z), float(level)))
    return drawn
