"""Missions and scenarios written as web pages."""

from pathlib import Path

from skyverse.atomic import write_text
from skyverse.draw.mission_page import page
from skyverse.draw.scenario_page import scenario_page
from skyverse.draw.scenario_scene import scenario_scene
from skyverse.draw.scene import scene
from skyverse.errors import require_kind
from skyverse.model.mission import Mission
from skyverse.model.scenario import Scenario


def write_html(mission: Mission | Scenario, path: str | Path) -> None:
    """Write a mission as one self-contained web page, or a scenario before anything is planned.

    The page of a scenario shows its obstacles, zones, ground, starts and targets, and marks those that are not safe.

    Raises
    ------
    InputError
        If it is neither, the folder does not exist or the file cannot be written.
    """
    require_kind(mission, (Mission, Scenario), "mission")
    require_kind(path, (str, Path), "path")
    text = scenario_page(scenario_scene(mission)) if isinstance(mission, Scenario) else page(scene(mission))
    write_text(Path(path), text)
