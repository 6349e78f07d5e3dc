"""The types of options that several verbs have."""

import re
from collections.abc import Sequence
from pathlib import Path
from typing import Annotated

from cyclopts import Parameter, Token

from skyverse.cli.completion import files, scenarios_and_files
from skyverse.errors import shown
from skyverse.planners import PLANNER_NAMES


def _whole_number(_: object, tokens: Sequence[Token]) -> int:
    """Read a whole number from 1 on, or from 0 on for a seed; cyclopts itself would cut 1.5 to 1."""
    text, option = tokens[0].value, tokens[0].keyword
    if not re.fullmatch(r"\+?\d{1,18}", text) or (int(text) == 0 and option != "--seed"):
        least = 0 if option == "--seed" else 1
        raise ValueError(f"expected a whole number from {least} on, found {shown(text)}")  # cyclopts names the option
    return int(text)


OUTPUT = Parameter(name=["--output", "-o"])
Output = Annotated[Path | None, OUTPUT]
FLAG = Parameter(negative="")
"""An option without a value, which has no opposite."""
SIGNED = Parameter(allow_leading_hyphen=True)
"""An option whose value may begin with a minus sign, also where it is more than one number, as in -1,0,0."""
AsJson = Annotated[bool, Parameter(name="--json"), FLAG]
WHOLE = Parameter(converter=_whole_number)
Whole = Annotated[int | None, WHOLE]
PLANNER = Parameter(choices=PLANNER_NAMES)
SCENARIO = Parameter(completer=scenarios_and_files)
GivenScenario = Annotated[str, SCENARIO]
GivenMission = Annotated[str, Parameter(completer=files)]
