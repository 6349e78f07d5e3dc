"""The verb ``scenarios``: the built-in scenarios, to list or to print."""

from typing import Annotated

from skyverse.cli.option_types import FLAG, AsJson, Output
from skyverse.cli.outputs import refuse_output
from skyverse.cli.report import json_text, table


def scenarios(
    name: str | None = None,
    /,
    *,
    schema: Annotated[bool, FLAG] = False,
    output: Output = None,
    as_json: AsJson = False,
) -> None:
    """List the built-in scenarios, or print one as YAML to start your own from.

    Examples: `skyverse scenarios`, `skyverse scenarios map1 -o mine.yaml`, `skyverse scenarios --schema`

    Parameters
    ----------
    name
        A built-in scenario, or a scenario or mission file.
    schema
        Print the JSON Schema of scenario files instead, for editors.
    output
        Write to this file (.yaml or .json) instead of printing.
    as_json
        Print JSON.
    """
    import skyverse as sky
    from skyverse.files import BUILTIN_NAMES
    from skyverse.files.scenarios import scenario_text

    if schema or name:
        if schema:
            text = json_text(sky.scenario_schema())
        else:
            text = scenario_text(sky.read_scenario(str(name)), ".json" if as_json else ".yaml")
        if output is None:
            print(text, end="")
        elif schema:
            from skyverse.atomic import write_text

            write_text(output, text)
        else:
            refuse_output(output, str(name))
            sky.write(sky.read_scenario(str(name)), output)
        return
    rows = [
        {"name": s.name, "uavs": len(s.uavs), "obstacles": len(s.obstacles), "description": s.description}
        for s in map(sky.read_scenario, BUILTIN_NAMES)
    ]
    if as_json:
        print(json_text(rows), end="")
    else:
        table(list(rows[0]), [[str(v) for v in row.values()] for row in rows])
