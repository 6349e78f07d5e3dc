"""The types of options that several verbs have, and what the shell completes them with."""

import re
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

from cyclopts import Parameter, Token

from skyverse.errors import shown
from skyverse.planners import PLANNER_NAMES

if TYPE_CHECKING:
    from cyclopts.completion import CompletionContext


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


def scenarios_and_files(context: "CompletionContext") -> Iterator[str]:
    """Yield the names of the built-in scenarios, and the files that begin with what is typed."""
    from skyverse.files import BUILTIN_NAMES

    yield from BUILTIN_NAMES
    yield from files(context)


def files(context: "CompletionContext") -> Iterator[str]:
    """Yield the files and folders that begin with what is typed; of a single folder also what is in it.

    The shell would end the word after a folder that is the only answer.
    """
    typed = context.incomplete
    found = list(_beginning_with(typed))
    yield from found
    if len(found) == 1 and found[0].endswith("/"):
        yield from _beginning_with(found[0])


def _beginning_with(typed: str) -> Iterator[str]:
    """Yield the paths that begin with what is typed, folders with a slash; hidden ones only where a dot is typed."""
    folder, slash, start = typed.rpartition("/")
    try:
        entries = sorted(Path(folder + slash or ".").iterdir())
    except OSError:
        return
    for entry in entries:
        if entry.name.startswith(start) and (start or not entry.name.startswith(".")):
            yield f"{folder}{slash}{entry.name}{'/' if entry.is_dir() else ''}"


SCENARIO = Parameter(completer=scenarios_and_files)
GivenScenario = Annotated[str, SCENARIO]
GivenMission = Annotated[str, Parameter(completer=files)]
