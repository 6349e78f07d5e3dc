"""The verbs ``check`` and ``show``: a mission judged; a mission or a scenario drawn."""

import sys
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Literal

from cyclopts import Parameter

from skyverse.cli.exit_codes import FOUND_WRONG
from skyverse.cli.given_scenario import judging_scenario, tell_unknown, without_way
from skyverse.cli.option_names import for_command_line
from skyverse.cli.option_types import FLAG, AsJson, GivenMission, GivenScenario, Output
from skyverse.cli.outputs import DEFAULT_FOLDER, make_folder, refuse_output
from skyverse.cli.report import json_text, violation_data
from skyverse.errors import InputError
from skyverse.model.short_lines import counted

if TYPE_CHECKING:
    from skyverse.model.mission import Mission
    from skyverse.model.scenario import Scenario


def check(
    mission: GivenMission,
    /,
    *,
    scenario: GivenScenario | None = None,
    as_json: AsJson = False,
) -> int:
    """Let the referee judge a mission file, whatever planned it.

    It prints what is wrong, and then what is proven of each UAV's flight and of the fleet, each in one sentence.

    Example: `skyverse check out/table-4.8.json --scenario table-4.8`

    Exit code: 0 when all is proven; 1 when anything is wrong or cannot be decided, or when a UAV has no way; 2 for bad
    input.

    Parameters
    ----------
    mission
        A mission file.
    scenario
        The scenario that the mission has to answer, a file or a built-in name; what differs from it in the mission is
        named. Without it, the mission is judged by the scenario that it embeds, whoever wrote that.
    as_json
        Print the violations as JSON.
    """
    import skyverse as sky
    from skyverse.referee import judge
    from skyverse.space.mission_cautions import mission_cautions

    judged = sky.read_mission(mission)
    world, judged_by = judging_scenario(judged, scenario)
    violations, certificates = judge(world, judged)
    if as_json:
        print(json_text([violation_data(v) for v in violations]), end="")
    else:
        for violation in violations:
            print(f"{violation.fault.value}: {violation.message}")
        print(f"{counted(len(violations), 'violation')} found." if violations else "The referee found nothing wrong.")
    aside = sys.stderr if as_json else sys.stdout
    print(judged_by, file=aside)
    apart = certificates.apart if len(world.uavs) > 1 else None
    for certificate in (*certificates.trajectories, apart):
        if certificate is not None and certificate.verdict is sky.Verdict.PROVEN:
            print(f"proven: {certificate.sentence}", file=aside)
    for caution in mission_cautions(replace(judged, scenario=world)):
        print(for_command_line(caution.sentence), file=aside)
    if any(result is not None and result.status is sky.Status.OPTIMAL for result in judged.results):
        print("Where a path is called optimal, it is so as claimed by the planner.", file=aside)
    if not judged.complete:
        print(without_way(judged), file=sys.stderr)
    return FOUND_WRONG if violations or not judged.complete else 0


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

    read = sky.read(mission_or_scenario, unknown=unknown)
    drawn: Mission | Scenario = _judged_anew(read) if isinstance(read, sky.Mission) else read
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


def _judged_anew(mission: "Mission") -> "Mission":
    """Return a mission with the referee's verdict in place of the one that its file claims."""
    from skyverse.referee import judge

    violations, (certificates, apart) = judge(mission.scenario, mission)
    return replace(mission, violations=tuple(violations), certificates=certificates, apart=apart)
