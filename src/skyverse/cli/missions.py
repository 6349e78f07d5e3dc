"""The verbs ``check`` and ``show``: a mission judged, and drawn."""

import sys
from pathlib import Path
from typing import Annotated

from cyclopts import Parameter

from skyverse.cli.exit_codes import FOUND_WRONG
from skyverse.cli.given_scenario import without_way
from skyverse.cli.option_types import FLAG, AsJson, Output
from skyverse.cli.outputs import make_folder, refuse_output
from skyverse.cli.report import json_text, violation_data
from skyverse.errors import InputError


def check(mission: str, /, *, scenario: str | None = None, as_json: AsJson = False) -> int:
    """Let the referee judge a mission file, whatever planned it; exit code 1 if anything is wrong.

    Example: `skyverse check out/table-4.8.json`

    Parameters
    ----------
    mission
        A mission file.
    scenario
        Judge it against this scenario instead of the one that it embeds.
    as_json
        Print the violations as JSON.
    """
    import skyverse as sky

    judged = sky.read_mission(mission)
    violations = sky.check(judged.scenario if scenario is None else sky.read_scenario(scenario), judged)
    if as_json:
        print(json_text([violation_data(v) for v in violations]), end="")
    else:
        for violation in violations:
            print(f"{violation.fault.value}: {violation.message}")
        print(f"{len(violations)} found." if violations else "The referee found nothing wrong.")
    if not judged.complete:
        print(without_way(judged), file=sys.stderr)
    return FOUND_WRONG if violations or not judged.complete else 0


def show(
    mission: str,
    /,
    *,
    output: Output = None,
    figures: Path | None = None,
    browse: Annotated[bool, Parameter(name="--open"), FLAG] = False,
) -> None:
    """Draw a mission: a page that flies it, or static figures.

    Examples: `skyverse show out/table-4.8.json --open`, `skyverse show out/table-4.8.json --figures figures/`

    Parameters
    ----------
    mission
        A mission file.
    output
        The page, .html; by default beside the mission file.
    figures
        Write figures (PNG) into this folder instead.
    browse
        Open the page in the browser.
    """
    import skyverse as sky

    drawn = sky.read_mission(mission)
    if figures is not None:
        make_folder(figures)
        for path in sky.write_figures(drawn, figures):
            print(path)
        return
    page = output if output is not None else Path(mission).with_suffix(".html")
    if page.suffix.lower() not in (".html", ".htm"):
        raise InputError(f"--output: expected a file ending in .html, found {str(page)!r}")
    refuse_output(page)
    sky.write_html(drawn, page)
    print(page)
    if browse:
        import webbrowser

        webbrowser.open(page.resolve().as_uri())
