"""The verb ``scenarios``: the built-in scenarios, to list or to print."""

import sys
from typing import Annotated

from skyverse.atomic import write_text
from skyverse.cli.option_types import FLAG, AsJson, GivenScenario, Output
from skyverse.cli.outputs import refuse_output
from skyverse.cli.report import json_text, table
from skyverse.errors import InputError


def scenarios(
    name: GivenScenario | None = None,
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
    from skyverse.files.scenarios import printed_scenario

    if schema and name:
        raise InputError(f"--schema: expected it alone, found {name!r} with it")
    if output is not None and not (schema or name):
        raise InputError("--output: expected a scenario to write, or --schema, found neither")
    if output is not None:
        refuse_output(output, *([name] if name else []))
    if schema:
        text = json_text(sky.scenario_schema())
        if output is None:
            print(text, end="")
        else:
            write_text(output, text)
        return
    if name:
        scenario = sky.read_scenario(name)
        if output is None:
            text, left_out = printed_scenario(scenario, ".json" if as_json else ".yaml")
            print(text, end="")
            if left_out:
                many = "one array is" if left_out == 1 else f"{left_out} arrays are"
                print(f"{many} too large to be printed; -o FILE writes the whole scenario", file=sys.stderr)
        else:
            sky.write(scenario, output)
        return
    rows = [
        {"name": s.name, "uavs": len(s.uavs), "obstacles": len(s.obstacles), "description": s.description}
        for s in map(sky.read_scenario, BUILTIN_NAMES)
    ]
    if as_json:
        print(json_text(rows), end="")
    else:
        table(list(rows[0]), [[str(v) for v in row.values()] for row in rows])
