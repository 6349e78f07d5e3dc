"""Scenario files: YAML, JSON, and the map files of the MEAM 620 course."""

import json
from pathlib import Path
from typing import Any

from numpy.typing import NDArray
from pydantic import TypeAdapter, ValidationError

from skyverse.documents.yaml import yaml_text
from skyverse.errors import InputError, require_file, shown, unreadable
from skyverse.files.builtin import THESIS_CLEARANCE, THESIS_LATTICE
from skyverse.files.document import explained, parse, read_text
from skyverse.files.grid_archive import beside
from skyverse.files.recorded_motions import RecordedMotion, with_recorded_motions
from skyverse.files.survey_files import with_survey_files
from skyverse.model.built_with import BuiltWith, Words
from skyverse.model.scenario import Bounds, Scenario
from skyverse.model.shapes import Box
from skyverse.model.vehicle_profiles import limits_without_value
from skyverse.model.wrong_values import keys_of_schema


def scenario_from_data(source: str | Path, data: Any) -> Scenario:
    """Return the scenario that a file's data describe, or raise `InputError` that names file and field."""
    if not isinstance(data, dict):
        raise InputError(
            f"{source}: expected a scenario, a mapping with the key 'bounds' and others, found {shown(data)}"
        )
    data = with_survey_files(Path(source), with_recorded_motions(Path(source), data))
    try:
        return Scenario.model_validate(data, context=beside(Path(source)))
    except ValidationError as error:
        raise explained(source, error, data, keys_of_schema(scenario_schema())) from None


def options_built_with(source: Path) -> Words:
    """Return the options of ``scenario build`` that a file keeps, of a scenario that may be too old to be read."""
    require_file(source)
    data = parse(source, read_text(source))
    scenario = data.get("scenario", data) if isinstance(data, dict) else {}
    given = scenario.get("built_with", ()) if isinstance(scenario, dict) else ()
    try:
        words: Words = TypeAdapter(BuiltWith).validate_python(given, context=beside(source))
    except ValidationError as error:
        raise explained(f"{source}: built_with", error, given, set()) from None
    return words


MAX_PRINTED_NUMBERS = 100_000
"""Numbers of one array at most that `printed_scenario` shows: more take minutes, and no reader of YAML takes them."""


def scenario_text(scenario: Scenario, suffix: str, context: dict[str, Any] | None = None) -> str:
    """Return a scenario as the text of a YAML or JSON file, written with the context of its archive if there is one."""
    data = scenario.model_dump(mode="json", exclude_none=True, context=context)
    for uav in data["uavs"]:
        uav |= limits_without_value(uav["vehicle"], uav)  # or else the profile's would be read
    return yaml_text(data) if suffix in (".yaml", ".yml") else json.dumps(data, indent=2) + "\n"


def printed_scenario(scenario: Scenario, suffix: str) -> tuple[str, int]:
    """Return a scenario as text to be read by people, and how many arrays in it are too large to be shown.

    In the place of such an array stands its shape, and how many voxels are occupied, or the least and greatest height.
    """
    left_out = 0

    def summary(array: NDArray[Any]) -> object:
        nonlocal left_out
        if array.size <= MAX_PRINTED_NUMBERS:
            return array.astype(int).tolist() if array.dtype == bool else array.tolist()
        left_out += 1
        if array.dtype == bool:
            return {"shape": list(array.shape), "occupied": int(array.sum())}
        return {"shape": list(array.shape), "least": float(array.min()), "greatest": float(array.max())}

    return scenario_text(scenario, suffix, {"side": summary}), left_out


def scenario_schema() -> dict[str, Any]:
    """Return the JSON Schema of scenario files, for editors."""
    schema = Scenario.model_json_schema()
    schema["$defs"]["RecordedMotion"] = RecordedMotion.model_json_schema()
    schema["$defs"]["Mover"]["properties"]["motion"]["oneOf"].append({"$ref": "#/$defs/RecordedMotion"})
    seen = schema["$defs"]["Survey"]["properties"]
    for field in ("area", "line"):
        seen[field] = {"anyOf": [seen[field], {"type": "string", "description": "A file, beside the scenario's."}]}
    return {"$schema": "https://json-schema.org/draft/2020-12/schema", **schema}


def course_map(source: Path, text: str) -> Scenario:
    """Read a map file of the MEAM 620 quadrotor course: a ``boundary`` line and ``block`` lines, in any order.

    Each holds six numbers in metres; the colour of a block is not read. Such a file has no UAVs and targets; clearance
    and lattice are those of the thesis.
    """
    bounds: Bounds | None = None
    boxes: list[Box] = []
    for number, line in enumerate(text.splitlines(), 1):
        words = line.split("#")[0].split()
        if not words:
            continue
        where = f"{source}: line {number}"
        if words[0] not in ("boundary", "block"):
            raise InputError(f"{where}: expected 'boundary' or 'block', found {words[0]!r:.40}")
        counts, colour = ((6,), "") if words[0] == "boundary" else ((6, 9), " and a colour")
        with unreadable(where, words[0], ValueError):
            numbers = [float(word) for word in words[1:]]
        if len(numbers) not in counts:
            raise InputError(f"{where}: {words[0]}: expected six numbers{colour}, found {len(numbers)}")
        corners = {"min": tuple(numbers[:3]), "max": tuple(numbers[3:6])}
        try:
            if words[0] == "block":
                boxes.append(Box.model_validate(corners))
            elif bounds is not None:
                raise InputError(f"{where}: a second boundary")
            else:
                bounds = Bounds.model_validate(corners)
        except ValidationError as error:
            raise explained(f"{where}: {words[0]}", error, corners, set()) from None
    if bounds is None:
        raise InputError(f"{source}: there is no 'boundary' line")
    data = {
        "name": source.stem,
        "bounds": bounds,
        "obstacles": tuple(boxes),
        "clearance": THESIS_CLEARANCE,
        "lattice": THESIS_LATTICE,
    }
    try:
        return Scenario.model_validate(data)
    except ValidationError as error:
        raise explained(source, error, data, set()) from None
