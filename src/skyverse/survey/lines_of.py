"""The lines of a survey, by its pattern."""

import math

from skyverse.errors import InputError
from skyverse.model.scenario import Scenario
from skyverse.survey.lines import SurveyLines


def lines_of(scenario: Scenario, number: int) -> SurveyLines:
    """Return the lines of one of a scenario's surveys, by its index, and what they do not see.

    Raises
    ------
    InputError
        If the survey cannot be flown as it is asked for.
    """
    from skyverse.survey.ground_lines import ground_lines
    from skyverse.survey.structure_lines import structure_lines

    if not scenario.surveys[number].of_ground:
        return structure_lines(scenario, number)
    _require_above_clearance(scenario, number)
    return ground_lines(scenario, number)


def _require_above_clearance(scenario: Scenario, number: int) -> None:
    """Refuse photos that would be taken from below the clearance from the ground, whatever the relief."""
    survey = scenario.surveys[number]
    flying = [uav for uav in scenario.uavs if not survey.uavs or uav.name in survey.uavs]
    strays = min((uav.tracking_error.vertical for uav in flying), default=0.0)
    kept = scenario.ground_clearance + strays
    high = survey.distance * math.sin(math.radians(-survey.pitch))
    if 0.0 < high < kept:
        raise InputError(
            f"expected photos from {kept:.4g} m above ground or more, the clearance and the tracking error, found "
            f"{high:.4g} m",
            field="height" if survey.gsd is None else "gsd",
        )
