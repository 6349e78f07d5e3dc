"""The ground that is to be seen of a survey, as a geometry of shapely."""

from typing import Any

from skyverse.model.survey import Survey


def asked_ground(survey: Survey) -> Any:
    """Return the ground that a survey is to show, seen from above, metres: its area and a margin.

    Along a line, that is all within half its width, with flat ends and round bends.
    """
    from shapely import LineString, Polygon, union_all  # it loads only where surveys are planned, judged or drawn

    if survey.line:
        shape = LineString(survey.line).buffer((survey.width or 0.0) / 2, cap_style="flat")
    else:
        shape = union_all([Polygon(one.vertices, one.holes) for one in survey.area])
    return shape.buffer(survey.margin) if survey.margin else shape
