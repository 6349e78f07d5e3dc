"""The photos that are expected of a flight, in files beside its own: a table, and a ``geo.txt`` for OpenDroneMap."""

from pathlib import Path

from skyverse.exports.flight_plan import FlightPlan
from skyverse.exports.global_positions import origin_of
from skyverse.model.geodesy import to_wgs84
from skyverse.model.mission import Mission
from skyverse.model.photos import Photos, photos_of
from skyverse.orders.places import written

SUFFIXES = (".photos.csv", ".geo.txt")
HEADER = "id,latitude,longitude,altitude_amsl_m,heading_deg,pitch_deg,roll_deg,sortie,strip,survey"
LOOKS_DOWN = 90.0
"""Degrees that OpenDroneMap counts more than others: its pitch is 0 straight down."""


def expected_photos(mission: Mission, plan: FlightPlan) -> Photos:
    """Return the photos of one flight, in the order in which they are taken."""
    photos, strips = photos_of(mission), {run.strip for run in plan.route.runs}
    own = [uav == plan.route.uav and strip in strips for uav, strip in zip(photos.uav, photos.strip, strict=True)]
    return photos.taken(own)  # type: ignore[arg-type]


def photo_files(mission: Mission, plan: FlightPlan, file: Path, suffix: str) -> dict[Path, str]:
    """Return the texts of the files of expected photos beside a flight's own file; none of a flight without photos."""
    photos, route = expected_photos(mission, plan), plan.route
    if not route.runs:
        return {}
    rows, geo = [HEADER], ["EPSG:4326"]
    stem, surveys = (
        file.name[: -len(suffix)],
        {run.strip: mission.scenario.surveys[run.survey].name for run in route.runs},
    )
    angles = zip(photos.heading, photos.pitch, photos.roll, photos.strip, strict=True)
    places = to_wgs84(origin_of(mission.scenario), photos.position)
    for number, (place, (heading, pitch, roll, strip)) in enumerate(zip(places, angles, strict=True), 1):
        name = f"{stem}-{number:04}"
        latitude, longitude, sea = written(place[0], 9), written(place[1], 9), written(place[2], 3)
        yaw, down, roll = (written(angle, 3) for angle in (heading, pitch, roll))
        survey = surveys[int(strip)].replace('"', '""')
        rows.append(
            f'{name},{latitude},{longitude},{sea},{yaw},{down},{roll},{max(route.sortie, 1)},{strip + 1},"{survey}"'
        )
        geo.append(f"{name}.jpg {longitude} {latitude} {sea} {yaw} {written(pitch + LOOKS_DOWN, 3)} {roll}")
    texts = ("\n".join(rows) + "\n", "\n".join(geo) + "\n")
    return {file.with_name(stem + ending): text for ending, text in zip(SUFFIXES, texts, strict=True)}
