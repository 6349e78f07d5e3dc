"""The lines of a survey, by its pattern."""

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
    return ground_lines(scenario, number)
