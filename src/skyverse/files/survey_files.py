"""Surveys of scenario files whose area or line stands in a file of its own: it is read, and takes the file's place."""

from pathlib import Path
from typing import Any

from skyverse.errors import InputError
from skyverse.files.recorded_motions import origin_of
from skyverse.model.frame import Origin


def with_survey_files(source: Path, data: dict[str, Any]) -> dict[str, Any]:
    """Return the data of a scenario file, in which each survey's area or line is read whose value is a file's name.

    Files are sought beside the scenario's.

    Raises
    ------
    InputError
        If a file cannot be used, or the frame has no origin; the message names both files, and the field.
    """
    surveys = data.get("surveys")
    if not isinstance(surveys, list) or not any(map(_files, surveys)):
        return data
    origin, read = origin_of(source, data), []
    for number, survey in enumerate(surveys):
        found = {}
        for field, name in _files(survey).items():
            place = f"{source}: surveys[{number}].{field}"
            if origin is None:
                raise InputError(f"{place}: {name!r:.60} is in degrees, but the scenario has no frame.origin")
            try:
                found[field] = _read(field, source.parent / name, origin)
            except InputError as error:
                raise InputError(f"{place}: {error}") from None
        read.append({**survey, **found} if found else survey)
    return {**data, "surveys": read}


def _files(survey: object) -> dict[str, str]:
    """Return the names of files that a survey gives, by field."""
    given = survey if isinstance(survey, dict) else {}
    return {field: given[field] for field in ("area", "line") if isinstance(given.get(field), str)}


def _read(field: str, path: Path, origin: Origin) -> object:
    from skyverse.maps.readers.areas import read_area, read_lines

    if field == "area":
        return [part.model_dump() for part in read_area(path, origin)]
    lines = read_lines(path, origin)
    if len(lines) > 1:
        raise InputError(f"{path}: expected one line, found {len(lines)}")
    return lines[0]
