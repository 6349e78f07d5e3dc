"""The text that identifies a scenario in a study: the same for one that version 1 of the format could say too."""

from pydantic import BaseModel

from skyverse.model.arrays import equal
from skyverse.model.formats import NEW_IN_SCENARIO_2, SCENARIO_1, SCENARIO_2
from skyverse.model.quantities import derived
from skyverse.model.scenario import Scenario


def scenario_text(scenario: Scenario) -> str:
    """Return a scenario as JSON, as version 1 of the format wrote it if none of the limits of version 2 is set.

    The runs of studies are found again by this text, so that a study which an older version began can go on.
    """
    scenario = derived(scenario, built_with=())  # where files are does not matter
    parts: dict[str, tuple[BaseModel, ...]] = {
        "": (scenario,),
        "uavs": scenario.uavs,
        "obstacles": scenario.obstacles,
        "zones": scenario.zones,
        "sources": scenario.sources,
        "terrain": () if scenario.terrain is None else (scenario.terrain,),
    }
    if any(
        not equal(getattr(entry, name), type(entry).model_fields[name].default)
        for part, names in NEW_IN_SCENARIO_2.items()
        for entry in parts[part]
        for name in names
    ):
        return scenario.model_dump_json()
    # a terrain without `lowest` does not write it
    listed = {part: names for part, names in NEW_IN_SCENARIO_2.items() if part not in ("", "terrain")}
    added = {part: {"__all__": set(names)} for part, names in listed.items()}
    text = scenario.model_dump_json(exclude={**added, **dict.fromkeys(NEW_IN_SCENARIO_2[""], True)})
    return text.replace(SCENARIO_2, SCENARIO_1, 1)
