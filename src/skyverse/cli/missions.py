"""The verb ``show``: a mission or a scenario drawn."""

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Literal

from cyclopts import Parameter

from skyverse.cli.given_scenario import tell_unknown
from skyverse.cli.option_types import FLAG, GivenScenario, Output
from skyverse.cli.outputs import DEFAULT_FOLDER, make_folder, refuse_output
from skyverse.errors import InputError

if TYPE_CHECKING:
    from skyverse.model.mission import Mission
    from skyverse.model.scenario import Scenario


def show(
    mission_or_scenario: GivenScenario,
    /,
    *,
    output: Output = None,
    figures: Path | None = None,
    unknown: Literal["free", "occupied"] | None = None,
    browse: Annotated[bool, Parameter(name="--open"), FLAG] = False,
) -> None:
    """Draw a mission, judged anew, or a scenario before it is planned: a page, or static figures.

    A scenario's page shows obstacles, zones, ground, starts and targets, and marks those that are not safe.

    Examples: `skyverse show out/table-4.8.json --open`, `skyverse show out/table-4.8.json --figures figures/`,
    `skyverse show mine.yaml --open`

    Parameters
    ----------
    mission_or_scenario
        A mission file, or a scenario: a built-in one, a scenario file or a map in local metres.
    output
        The page, .html; by default beside the file; for a built-in scenario, out/NAME-scenario.html.
    figures
        Write figures (PNG) into this folder instead.
    unknown
        What an OctoMap's unknown space is taken for; occupied when left out, if the map says what is free.
    browse
        Open the page in the browser.
    """
    import skyverse as sky
    from skyverse.files import BUILTIN_NAMES
    from skyverse.referee import judged

    read = sky.read(mission_or_scenario, unknown=unknown)
    drawn: Mission | Scenario = judged(read.scenario, read) if isinstance(read, sky.Mission) else read
    if isinstance(drawn, sky.Scenario):
        tell_unknown(drawn, unknown)
    if figures is not None:
        make_folder(figures)
        for path in sky.write_figures(drawn, figures):
            print(path)
        return
    beside = Path(mission_or_scenario).with_suffix(".html")
    if mission_or_scenario in BUILTIN_NAMES:  # whose missions have their pages in the same folder
        beside = DEFAULT_FOLDER / f"{mission_or_scenario}-scenario.html"
    page = output if output is not None else beside
    if page.suffix.lower() not in (".html", ".htm"):
        raise InputError(f"--output: expected a file ending in .html, found {str(page)!r}")
    refuse_output(page)
    sky.write_html(drawn, page)
    print(page)
    if browse:
        import webbrowser

        webbrowser.open(page.resolve().as_uri())
