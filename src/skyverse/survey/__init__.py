"""Surveys: from what is to be seen to the lines along which photos are taken."""

from skyverse.survey.lines import PhotoLine, SurveyLines
from skyverse.survey.lines_of import lines_of

__all__ = ["PhotoLine", "SurveyLines", "lines_of"]
