"""QGroundControl's own survey item around proven items, so that QGroundControl shows them as a survey.

Keys are those of `SurveyComplexItem` 5, `TransectStyleComplexItem` 2 and `CameraCalc` 2. What is stored in it is flown
as long as nobody edits the item; then QGroundControl puts items of its own in their place.
"""

import math
from collections.abc import Sequence

import numpy as np

from skyverse._typing import Floats
from skyverse.exports.flight_plan import FlightPlan
from skyverse.exports.global_positions import AltitudeReference, origin_of
from skyverse.model.geodesy import to_wgs84
from skyverse.model.scenario import Scenario
from skyverse.model.survey import OF_AREAS, Survey
from skyverse.orders.mavlink_files import plan_item
from skyverse.orders.mavlink_items import Command, StoredItem

DISTANCE_MODES = {"home": 1, "amsl": 2, "agl": 4}
TRIGGERS = (Command.PHOTO_DISTANCE, Command.START_PHOTOS, Command.STOP_PHOTOS, Command.PHOTO)


def items_with_survey(
    items: Sequence[StoredItem], scenario: Scenario, plan: FlightPlan, reference: AltitudeReference
) -> list[dict[str, object]]:
    """Return the items of a ``.plan``, those from the first photo to the last in one survey item.

    Where photos are not of an area, or of several surveys, all items stay simple ones.
    """
    simple = [plan_item(item, k) for k, item in enumerate(items, 1)]
    surveys = {run.survey for run in plan.route.runs}
    survey = scenario.surveys[surveys.pop()] if len(surveys) == 1 else None
    if survey is None or survey.pattern not in OF_AREAS:
        return simple
    told = [k for k, item in enumerate(items) if item.command in TRIGGERS]
    on = next(k for k in told if items[k].command == Command.PHOTO or any(items[k].numbers))
    begin = max(k for k in range(on) if items[k].command == Command.WAYPOINT)
    begin = min([begin, *(k for k in range(begin) if items[k].command == Command.GIMBAL)])
    inner = simple[begin : told[-1] + 1]
    return [*simple[:begin], _complex(survey, scenario, plan, reference, inner), *simple[told[-1] + 1 :]]


def _complex(
    survey: Survey, scenario: Scenario, plan: FlightPlan, reference: AltitudeReference, inner: list[dict[str, object]]
) -> dict[str, object]:
    route, runs = plan.route, plan.route.runs
    ends = route.waypoints[[number for run in runs for number in (run.on, run.off)]]
    east, north = (ends[1] - ends[0])[:2] if len(ends) > 1 else (0.0, 1.0)
    transects = {
        "version": 2,
        "TurnAroundDistance": 0,
        "CameraTriggerInTurnAround": False,
        "HoverAndCapture": survey.trigger == "point",
        "Refly90Degrees": survey.pattern == "cross",
        "CameraShots": sum(run.count for run in runs),
        "CameraCalc": _camera(survey, reference, max(run.every for run in runs)),
        "VisualTransectPoints": _places(scenario, ends),
        "Items": inner,
    }
    return {
        "type": "ComplexItem",
        "complexItemType": "survey",
        "version": 5,
        "polygon": _places(
            scenario, np.column_stack([survey.area[0].vertices, np.zeros(len(survey.area[0].vertices))])
        ),
        "angle": round(math.degrees(math.atan2(east, north)) % 180.0, 3),
        "entryLocation": 0,
        "flyAlternateTransects": False,
        "splitConcavePolygons": False,
        "TransectStyleComplexItem": transects,
    }


def _camera(survey: Survey, reference: AltitudeReference, every: float) -> dict[str, object]:
    camera, distance = survey.camera, survey.distance
    across = 2.0 * camera.half_widths[0] * distance
    return {
        "version": 2,
        "DistanceMode": DISTANCE_MODES[reference],
        "DistanceToSurface": distance,
        "AdjustedFootprintFrontal": every,
        "AdjustedFootprintSide": across * (1.0 - survey.overlap[1] / 100.0),
        "CameraName": "Custom Camera",
        "SensorWidth": camera.sensor[0],
        "SensorHeight": camera.sensor[1],
        "ImageWidth": camera.image[0],
        "ImageHeight": camera.image[1],
        "FocalLength": camera.focal,
        "MinTriggerInterval": camera.min_interval,
        "Landscape": not camera.portrait,
        "FixedOrientation": False,
        "ValueSetIsDistance": survey.gsd is None,
        "ImageDensity": 100.0 * camera.gsd(distance),
        "FrontalOverlap": survey.overlap[0],
        "SideOverlap": survey.overlap[1],
    }


def _places(scenario: Scenario, points: Floats) -> list[list[float]]:
    return [[float(one[0]), float(one[1])] for one in to_wgs84(origin_of(scenario), points)]
